/* Collects the messages of FMUs, from any thread; see log.h. */

#if !defined(_WIN32)
#define _POSIX_C_SOURCE 200809L
#endif

#include <ctype.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"

#if defined(_WIN32)
#include <io.h>
#define EXPORT __declspec(dllexport)
#else
#include <unistd.h>
#define EXPORT __attribute__((visibility("default")))
#endif

enum { LAST = 50, KINDS = 20, TEXT = 2000 };

static volatile int busy;
static Log *open_logs;
static long long heard, most_messages = -1;
static int exit_code;

/* Messages are short and rare: the threads of one FMU hardly ever meet here. */
static void acquire(void)
{
    while (__sync_lock_test_and_set(&busy, 1))
        ;
}

static void release(void)
{
    __sync_lock_release(&busy);
}

EXPORT void open_log(Log *log)
{
    acquire();
    log->is_open = 1;
    log->next = open_logs;
    open_logs = log;
    release();
}

EXPORT void close_log(Log *log)
{
    acquire();
    for (Log **place = &open_logs; *place; place = &(*place)->next)
        if (*place == log) {
            *place = log->next;
            break;
        }
    log->is_open = 0;
    release();
}

/* More messages than `most` in this process end it with this exit code. */
EXPORT void limit_messages(long long most, int code)
{
    most_messages = most;
    exit_code = code;
}

static char sentence[TEXT];

static void say(void)
{
    if (*sentence && write(2, sentence, strlen(sentence)) < 0)
        return; /* there is nothing else to do */
}

/* By exit(); a regular end of Python takes the sentence back before. */
static __attribute__((destructor)) void on_exit_of_fmu(void)
{
    say();
    if (*sentence)
        _exit(3);
}

#if !defined(_WIN32)
static const int crashes[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL};
enum { CRASHES = sizeof crashes / sizeof *crashes };
static struct sigaction before[CRASHES];

static void on_crash(int number)
{
    say();
    for (int i = 0; i < CRASHES; i++)
        if (crashes[i] == number)
            sigaction(number, before + i, NULL);
    raise(number);
}
#endif

/* Until it is called with an empty text, the end of the process by code of an FMU prints this sentence. */
EXPORT void announce_end(const char *text)
{
#if !defined(_WIN32)
    const struct sigaction action = {.sa_handler = on_crash};

    for (int i = 0; i < CRASHES && !*sentence != !*text; i++)
        sigaction(crashes[i], *text ? &action : before + i, *text ? before + i : NULL);
#endif
    snprintf(sentence, sizeof sentence, "%s", text);
}

static const char *after_number(const char *text)
{
    if (*text == '-')
        text++;
    while (isdigit((unsigned char)*text) || *text == '.')
        text++;
    if ((*text == 'e' || *text == 'E') && (isdigit((unsigned char)text[1]) ||
                                           ((text[1] == '-' || text[1] == '+') && isdigit((unsigned char)text[2])))) {
        text += 2;
        while (isdigit((unsigned char)*text))
            text++;
    }
    return text;
}

static int begins_number(const char *text)
{
    return isdigit((unsigned char)text[*text == '-']);
}

/* A number in a reference to a variable, #r11#, is not one that a message reports. */
static int same_kind(const char *a, const char *b)
{
    int in_reference = 0;

    while (*a && *b) {
        if (!in_reference && begins_number(a) && begins_number(b)) {
            a = after_number(a);
            b = after_number(b);
            continue;
        }
        if (*a != *b)
            return 0;
        in_reference = *a == '#' ? !in_reference : in_reference && isalnum((unsigned char)*a);
        a++;
        b++;
    }
    return *a == *b;
}

static void note(Log *log, int status, const char *text)
{
    Message *last = log->last + log->heard++ % LAST;

    last->status = status;
    last->count = 1;
    snprintf(last->text, TEXT, "%s", text);
    if (status == 0)
        return;
    for (long long k = 0; k < log->n_kinds; k++)
        if (log->kinds[k].status == status && same_kind(log->kinds[k].text, last->text)) {
            log->kinds[k].count++;
            return;
        }
    if (log->n_kinds == KINDS)
        log->others++;
    else
        log->kinds[log->n_kinds++] = *last;
}

/* Some FMUs pass themselves instead of the environment that they were given. Only an open log is written to; the message
   goes to the only one if there is one. */
EXPORT void record(Log *log, int status, const char *text)
{
    if (!text || !*text)
        return;
    acquire();
    if (most_messages >= 0 && ++heard > most_messages)
        _exit(exit_code);
    Log *found = open_logs;
    while (found && found != log)
        found = found->next;
    if (!found && open_logs && !open_logs->next)
        found = open_logs;
    if (found)
        note(found, status, text);
    release();
}

/* fmi2CallbackLogger */
static void hear(void *environment, const char *instance, int status, const char *category, const char *message, ...)
{
    char text[TEXT];
    va_list arguments;

    (void)instance;
    (void)category;
    if (!message)
        return;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    record(environment, status, text);
}

EXPORT long long address_of_logger(void)
{
    return (long long)hear;
}
