/* HC_PUBLIC marks what a shared libhalocline shows; everything else in it is hidden. */
#ifndef HALOCLINE_EXPORT_H
#define HALOCLINE_EXPORT_H

#define HC_PUBLIC __attribute__((visibility("default")))

#endif
