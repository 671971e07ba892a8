#pragma once

// The library's own macros say which of its parts were compiled.
#include <httplib.h>
