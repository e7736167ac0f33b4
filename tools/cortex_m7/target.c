/* Runs the onboard library on a Cortex-M7 without an operating system: start-up, and a program that steps the library
 * over readings.bin and writes outputs.bin, both on the computer that has the debugger, by Arm semihosting.
 *
 * The generated file comes first: the header of the library, and its names as START_LIBRARY, STEP_LIBRARY, State, Inputs and Outputs.
 * Sources: Armv7-M Architecture Reference Manual (DDI 0403), B1.5 exceptions, B3.2.20 CPACR, B3.3 SysTick; Semihosting
 * for AArch32 and AArch64 (Arm IHI 0100), chapter 7. */
#include <stddef.h>

typedef unsigned int word;

enum { OPEN = 0x01, SAY = 0x04, WRITE = 0x05, READ = 0x06, EXIT = 0x18 }; /* calls of semihosting */
enum { FINISHED = 0x20026, FAILED = 0x20023 };                        /* reasons of EXIT: the application, a run-time error */
enum { FOR_READING = 1, FOR_WRITING = 5, PAINT = 0xA5A5A5A5, MARGIN = 64, LOOPS = 100000 };

#define SYSTICK ((volatile word *)0xE000E010) /* control, reload, current value, which counts down 24 bits */
#define CPACR ((volatile word *)0xE000ED88)
#define TICKS(since) (((since)-SYSTICK[2]) & 0xFFFFFF)

extern word stack_begin[], stack_end[], data_begin[], data_end[], data_load[], bss_begin[], bss_end[];

/* A row of outputs.bin. The first row has the ticks of a loop of 2 * LOOPS instructions, and of none. */
typedef struct {
    Outputs outputs;
    double ticks, failed;
} Row;

static State onboard;

static word host(word call, const void *arguments)
{
    register word number __asm__("r0") = call;
    register const void *block __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xab" : "+r"(number) : "r"(block) : "memory");
    return number;
}

static word open_file(const char *name, word length, word mode)
{
    const word arguments[] = {(word)name, mode, length};
    return host(OPEN, arguments);
}

/* Return the number of bytes that were not read or written. */
static word transfer(word call, word file, const void *from, word size)
{
    const word arguments[] = {file, (word)from, size};
    return host(call, arguments);
}

static void leave(word reason)
{
    for (;;)
        (void)host(EXIT, (const void *)reason);
}

static void fail(const char *sentence)
{
    (void)host(SAY, sentence);
    leave(FAILED);
}

static void stop(void) { fail("An exception of the processor ended the program.\n"); }

static void write_row(word file, const Row *row)
{
    if (transfer(WRITE, file, row, sizeof *row))
        fail("The program cannot write outputs.bin.\n");
}

/* The ticks of a number of subtractions and branches, for the time of an instruction. */
static word ticks_of(word loops)
{
    const word begin = SYSTICK[2];
    if (loops)
        __asm__ volatile("1: subs %0, #1\n bne 1b" : "+r"(loops) : : "cc");
    return TICKS(begin);
}

/* Number of bytes of the stack that were written below the stack of the caller. */
static word painted(const word *here)
{
    const word *lowest = stack_begin;
    while (*lowest == PAINT)
        lowest++;
    return (word)((const char *)here - (const char *)lowest);
}

/* Errors of the mathematical library, the only thing in it that is shared. */
int *__errno(void)
{
    static int number;
    return &number;
}

/* What a compiler may call in any environment, by the names of the C library. */
void *copy_bytes(void *restrict to, const void *restrict from, size_t size) __asm__("memcpy");
void *fill_bytes(void *to, int value, size_t size) __asm__("memset");

void *copy_bytes(void *restrict to, const void *restrict from, size_t size)
{
    for (size_t i = 0; i < size; i++)
        ((char *)to)[i] = ((const char *)from)[i];
    return to;
}

void *fill_bytes(void *to, int value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        ((char *)to)[i] = (char)value;
    return to;
}

static void run(void)
{
    const word in = open_file("readings.bin", 12, FOR_READING), out = open_file("outputs.bin", 11, FOR_WRITING);
    static Inputs inputs;
    static Row row;
    const word *here = __builtin_frame_address(0);

    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[0] = 5; /* the clock of the processor, without interrupts */
    row.ticks = (double)ticks_of(LOOPS);
    row.failed = (double)ticks_of(0);
    write_row(out, &row);
    for (word *at = stack_begin; at < here - MARGIN; at++)
        *at = PAINT;
    START_LIBRARY(&onboard);
    while (!transfer(READ, in, &inputs, sizeof inputs)) {
        const word begin = SYSTICK[2];
        row.failed = (double)STEP_LIBRARY(&onboard, &inputs, &row.outputs);
        row.ticks = (double)TICKS(begin);
        write_row(out, &row);
    }
    row.ticks = (double)painted(here);
    write_row(out, &row);
    leave(FINISHED);
}

void start(void)
{
    *CPACR |= 0xFu << 20; /* full access to the floating-point unit */
    __asm__ volatile("dsb\n isb");
    (void)copy_bytes(data_begin, data_load, (size_t)((char *)data_end - (char *)data_begin));
    (void)fill_bytes(bss_begin, 0, (size_t)((char *)bss_end - (char *)bss_begin));
    run();
}

/* Stack, reset, and the exceptions of the processor, each of which ends the run. */
__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_end, start, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop,
};
