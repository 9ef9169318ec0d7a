// SPDX-License-Identifier: MIT
// From reset to main on a Cortex-M7, with nothing but the linker script: vectors, floating point on, memory set up.
#include <cstdint>

extern "C" {
extern std::uint32_t data_from[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
extern void (*init_begin[])();
extern void (*init_end[])();
int main();
[[noreturn]] void leave(int status);

[[noreturn]] void reset() {
  *reinterpret_cast<volatile std::uint32_t*>(0xE000ED88) |= 0xFu << 20;  // coprocessors 10 and 11: floating point
  asm volatile("dsb\n isb");
  for (std::uint32_t *to = data_begin, *from = data_from; to != data_end;) *to++ = *from++;
  for (std::uint32_t* p = bss_begin; p != bss_end;) *p++ = 0;
  for (auto construct = init_begin; construct != init_end;) (*construct++)();
  leave(main());
}
[[noreturn]] void trap() { leave(99); }  // any fault ends the run: no trap is part of the claim

[[gnu::section(".vectors"), gnu::used]] const std::uintptr_t vectors[16] = {
    reinterpret_cast<std::uintptr_t>(stack_top), reinterpret_cast<std::uintptr_t>(&reset),
    reinterpret_cast<std::uintptr_t>(&trap),     reinterpret_cast<std::uintptr_t>(&trap),
    reinterpret_cast<std::uintptr_t>(&trap),     reinterpret_cast<std::uintptr_t>(&trap),
    reinterpret_cast<std::uintptr_t>(&trap)};
}
