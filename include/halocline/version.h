#ifndef HALOCLINE_VERSION_H
#define HALOCLINE_VERSION_H

#include "halocline/export.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The library's version, such as "0.1.0". Local; the string is static. */
HC_PUBLIC const char *hc_version(void);

#ifdef __cplusplus
}
#endif
#endif
