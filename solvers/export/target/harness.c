/* Images some frames and prints, for each, the instructions of image and contacts and a checksum of both;
   at the end the bytes of stack. On a Cortex-M the program is all there is, its output goes by semihosting,
   and time is SysTick under QEMU's -icount shift=0, where an instruction takes a nanosecond. */
#include <stdint.h>
#include <string.h>

#include "solver.h"

#if defined(__arm__) && __ARM_ARCH_PROFILE == 'M'
#define CORTEX_M
#endif

extern const int32_t ert_frame_count;
extern const float ert_frames[]; /* the reference, then the frames [ert_frame_count][ERT_CHANNELS] */

static ErtSolver solver;
static float image[ERT_PIXELS];
static ErtContact contacts[ERT_MOST_CONTACTS];

#ifdef CORTEX_M
#define SYSTICK ((volatile uint32_t *)0xE000E010u)
#define NS_A_TICK 40u /* of the boards' 25 MHz */
#define PAINT 0xC5C5C5C5u

extern uint32_t bss_begin, bss_end, stack_top;
void reset(void);

__attribute__((section(".vectors"), used)) static void *const vectors[2] = {&stack_top,
                                                                          (void *)reset};

static int semihosting(int call, const void *argument)
{
  register int r0 __asm__("r0") = call;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static void write_text(const char *text) { semihosting(4, text); }
static void start_clock(void)
{
  SYSTICK[1] = 0xFFFFFFu;
  SYSTICK[2] = 0;
  SYSTICK[0] = 5;
}
static uint32_t instructions(void) { return (0xFFFFFFu - SYSTICK[2]) * NS_A_TICK; }
#else
#include <stdio.h>
static void write_text(const char *text) { fputs(text, stdout); }
static void start_clock(void) {}
static uint32_t instructions(void) { return 0; }
#endif

static void write_number(uint32_t number, const char *end)
{
  char digits[12];
  int at = 11;
  digits[at] = '\0';
  do {
    digits[--at] = (char)('0' + number % 10);
    number /= 10;
  } while (number != 0);
  write_text(digits + at);
  write_text(end);
}

/* FNV-1a. */
static uint32_t checksum(const void *bytes, uint32_t count, uint32_t sum)
{
  const uint8_t *byte = bytes;
  for (; count > 0; --count) {
    sum = (sum ^ *byte++) * 16777619u;
  }
  return sum;
}

int main(void)
{
  int32_t f;
  ert_start(&solver);
  ert_set_reference(&solver, ert_frames);
  for (f = 1; f <= ert_frame_count; ++f) {
    uint32_t both;
    uint32_t sum;
    int32_t found;
    start_clock();
    ert_image(&solver, ert_frames + f * ERT_CHANNELS, image);
    found = ert_contacts(&solver, image, contacts);
    both = instructions();
    sum = checksum(image, sizeof image, 2166136261u);
    sum = checksum(contacts, (uint32_t)found * sizeof contacts[0], sum);
    write_number(both, " ");
    write_number(sum, "\n");
  }
  return 0;
}

#ifdef CORTEX_M
void reset(void)
{
  uint32_t *word;
  uint32_t *const end = (uint32_t *)__builtin_frame_address(0) - 64;
#ifdef __ARM_FP
  *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* the floating point unit */
  __asm__ volatile("dsb\n isb");
#endif
  for (word = &bss_begin; word < &bss_end; ++word) {
    *word = 0;
  }
  for (word = &bss_end; word < end; ++word) {
    *word = PAINT;
  }
  main();
  for (word = &bss_end; *word == PAINT; ++word) {
  }
  write_number((uint32_t)((uint8_t *)&stack_top - (uint8_t *)word), " stack\n");
  semihosting(0x18, (const void *)0x20026);
  for (;;) {
  }
}
#endif
