/* The natural logarithm from + - * / alone: the same bits on every machine. */
#ifndef HC_LOGARITHM_H
#define HC_LOGARITHM_H

/* ln x to about 1e-16 of its own size, or of 1; x positive and finite. */
double hc_logarithm(double x);

#endif
