#pragma once

#include <stdexcept>
#include <string>

namespace penumbra {

/// Something outside the program went wrong: input, driver, file. The message is one sentence that names
/// what, where, the value found and what to do; Python sees a class of the same name.
/// Bugs of ours are PENUMBRA_ASSERT, an ordinary "no" is a return value (Verdict, std::optional).
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// The scene cannot be rendered as given (shape, index, NaN, singular transform, ...).
class InvalidScene : public Error {
public:
    using Error::Error;
};

/// A technique id, setting key or setting value is not known or out of range.
class InvalidSettings : public Error {
public:
    using Error::Error;
};

/// No usable EGL device or OpenGL context, a lost context, a shader that the driver refuses.
class DeviceError : public Error {
public:
    using Error::Error;
};

/// The device or the process has not enough memory for what was asked.
class OutOfMemory : public Error {
public:
    using Error::Error;
};

/// The caller cancelled the work; nothing of it is kept.
class Cancelled : public Error {
public:
    Cancelled() : Error("cancelled") {}
};

}  // namespace penumbra
