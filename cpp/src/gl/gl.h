#pragma once

// The one way to reach OpenGL: glad's table, filled at run time from libEGL. Nothing here links libGL.
#include <glad/gl.h>
