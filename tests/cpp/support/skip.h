#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

/// Skips the test where the machine lacks something; fails instead where PENUMBRA_MUST_RUN is set, as ./test does,
/// so that a broken driver cannot pass for a short test list.
#define PENUMBRA_SKIP(reason)                              \
    do {                                                   \
        if (std::getenv("PENUMBRA_MUST_RUN") != nullptr) { \
            FAIL() << "must run here, but " << (reason);   \
        }                                                  \
        GTEST_SKIP() << (reason);                          \
    } while (false)
