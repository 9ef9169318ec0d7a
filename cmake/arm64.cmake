# SPDX-License-Identifier: MIT
# Toolchain: arm64 by Debian's cross compiler, run by qemu-user. Eigen has headers alone, so this machine's serve.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L /usr/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
# Debian's library is for this machine, its sources for any.
set(GYROSTAT_GOOGLETEST /usr/src/googletest CACHE PATH "")
