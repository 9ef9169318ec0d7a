@ SPDX-License-Identifier: MIT
  .section .rodata
  .balign 8
  .global rows_begin, rows_end
rows_begin:
  .incbin "rows.bin"
rows_end:
