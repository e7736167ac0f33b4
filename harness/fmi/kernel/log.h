/* Messages of FMUs. They are collected without the interpreter: a worker thread of an FMU may log while the thread that
   holds the interpreter's lock waits for it in fmi2DoStep. */
#ifndef LOG_H
#define LOG_H

typedef struct {
    long long status, count; /* count: messages of this kind so far */
    char text[2000];         /* of the first one, cut */
} Message;

/* Two messages are of one kind if they differ only in numbers. */
typedef struct Log {
    Message last[50];  /* message number n is at n modulo 50 */
    Message kinds[20]; /* of warnings and worse, in the order of their first occurrence */
    long long heard, n_kinds, others;
    long long is_open;
    struct Log *next;
} Log;

void open_log(Log *log);
void close_log(Log *log);
void record(Log *log, int status, const char *text);
void limit_messages(long long most, int code);
void announce_end(const char *text);
long long address_of_logger(void);

#endif
