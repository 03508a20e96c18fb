#pragma once

#include <cstdio>
#include <cstdlib>

/// A bug of ours. Prints the expression and its place and aborts in debug and test builds, costs nothing else.
#if defined(PENUMBRA_DEBUG) || defined(PENUMBRA_SANITIZED)
#define PENUMBRA_ASSERT(condition)                                                                 \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            std::fprintf(stderr, "%s:%d: assertion failed: %s\n", __FILE__, __LINE__, #condition); \
            std::abort();                                                                          \
        }                                                                                          \
    } while (false)
#else
#define PENUMBRA_ASSERT(condition) static_cast<void>(0)
#endif
