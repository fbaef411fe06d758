/* Sine and cosine from + - * / and rounding only: the same bits on every machine. */
#ifndef HC_TURNS_H
#define HC_TURNS_H

/* sin and cos of 2 pi t, to about 1e-16. */
double hc_turns_sine(double t);
double hc_turns_cosine(double t);

#endif
