// SPDX-License-Identifier: MIT
// Steps the stack through the recorded rows and writes what it answers, the instructions of each step and the depth of
// the stack to a file of the host (semihosting).
#include <cstring>

#include "flight.hpp"

extern "C" {
extern std::uint32_t stack_limit[], stack_top[];
extern const std::uint32_t rows_begin[], rows_end[];  // rows.s: the recording, as it lies in memory

/// One request to the debugger or emulator. Its reads and writes are the host's.
[[gnu::noinline]] int semihosting(int what, const void* arguments) {
  register int r0 asm("r0") = what;
  register const void* r1 asm("r1") = arguments;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

[[noreturn]] void leave(int status) {
  const std::uint32_t arguments[2] = {0x20026u, static_cast<std::uint32_t>(status)};  // application exit
  semihosting(0x20, arguments);
  for (;;) asm volatile("wfi");
}
}

namespace {

/// The timer counts down at 25 MHz; the emulator lets an instruction take 256 ns (-icount shift=8), so 6.4 ticks are one.
class Timer {
 public:
  Timer() {
    reload() = 0xFFFFFFu;
    current() = 0;
    control() = 5;  // on, processor clock, no interrupt
  }
  std::uint32_t now() const { return 0xFFFFFFu - current(); }
  static std::uint32_t instructions(std::uint32_t from, std::uint32_t to) {
    return ((to - from & 0xFFFFFFu) * 10u + 32u) / 64u;
  }

 private:
  static volatile std::uint32_t& control() { return *reinterpret_cast<volatile std::uint32_t*>(0xE000E010); }
  static volatile std::uint32_t& reload() { return *reinterpret_cast<volatile std::uint32_t*>(0xE000E014); }
  static volatile std::uint32_t& current() { return *reinterpret_cast<volatile std::uint32_t*>(0xE000E018); }
};

constexpr std::uint32_t paint = 0xA5A5A5A5u;

[[gnu::noinline]] void paint_stack() {
  auto* here = static_cast<std::uint32_t*>(__builtin_frame_address(0)) - 16;
  for (std::uint32_t* p = stack_limit; p < here; ++p) *p = paint;
}

std::uint32_t painted_away() {
  const std::uint32_t* p = stack_limit;
  while (p < stack_top && *p == paint) ++p;
  return static_cast<std::uint32_t>(reinterpret_cast<const char*>(stack_top) - reinterpret_cast<const char*>(p));
}

void write(int file, const void* data, std::uint32_t bytes) {
  const std::uint32_t arguments[3] = {static_cast<std::uint32_t>(file),
                                      static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(data)), bytes};
  if (semihosting(0x05, arguments) != 0) leave(3);
}

int open_answers() {
  static const char name[] = "answers.bin";
  const std::uint32_t arguments[3] = {static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(name)), 5, 11};
  return semihosting(0x01, arguments);
}

}  // namespace

int main() {
  const int file = open_answers();
  if (file < 0) return 2;
  if (!flight_init()) return 1;
  const auto* rows = reinterpret_cast<const Row*>(rows_begin);
  const auto count = static_cast<std::uint32_t>(reinterpret_cast<const Row*>(rows_end) - rows);
  paint_stack();
  const std::uint32_t before = painted_away();
  Timer timer;
  static Answer answer;
  for (std::uint32_t k = 0; k < count; ++k) {
    std::memset(&answer, 0, sizeof answer);
    const std::uint32_t from = timer.now();
    flight_step(k, rows[k], answer);
    answer.instructions = Timer::instructions(from, timer.now());
    write(file, &answer, sizeof answer);
  }
  const std::uint32_t used[4] = {painted_away() - before, flight_bytes(), count, 0};
  write(file, used, sizeof used);
  return 0;
}
