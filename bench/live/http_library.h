#pragma once

// Eigen first: the library's header brings in <resolv.h>, whose macro `_res` is a name in Eigen.
#include <Eigen/Dense>

// How Debian built the library: its header asks whoever includes it for the same.
#define CPPHTTPLIB_OPENSSL_SUPPORT
#define CPPHTTPLIB_ZLIB_SUPPORT
#define CPPHTTPLIB_BROTLI_SUPPORT
#include <httplib.h>
#undef _res
