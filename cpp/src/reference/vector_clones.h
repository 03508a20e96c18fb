#pragma once

/// Before a function of lane loops: compiled for AVX2 besides the baseline, the machine chooses when the program
/// starts. Contraction to fused operations stays off (CMakeLists.txt), so both give the same numbers. Sanitizers cannot
/// run while such choices are made, other compilers and processors do without.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__linux__) && \
    !defined(PENUMBRA_SANITIZED)
#define PENUMBRA_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PENUMBRA_VECTOR_CLONES
#endif

/// For what such a function calls: a call that stays a call would stop the loop from becoming vector code.
#define PENUMBRA_INLINE inline __attribute__((always_inline))
