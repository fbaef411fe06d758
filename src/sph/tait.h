/* The pressure of a weakly compressible fluid: He et al. 2015, eq. 2, with the exponent 7. */
#ifndef HC_TAIT_H
#define HC_TAIT_H

typedef struct hc_tait {
  float stiffness; /* c^2/7, m2/s2 */
  int negative;    /* may pressures fall below 0? */
} hc_tait;

/* p/rho0, m2/s2, at the density of a fraction of the rest density. */
static inline float hc_tait_pressure(const hc_tait *tait, float relative) {
  const float square = relative * relative,
              pressure = tait->stiffness * (square * square * square * relative - 1.0f);
  return pressure > 0.0f || tait->negative ? pressure : 0.0f;
}

/* What pairs read of it: p/(rho0 D^2). */
static inline float hc_tait_push(float pressure, float relative) {
  return pressure / (relative * relative);
}

#endif
