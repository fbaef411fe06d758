/* Kernel sums over the rest lattice: what particle mass and wall volumes are derived from.
 *
 * Kernel: cubic spline of support radius h (Monaghan 1992), W = s (6 (q^3 - q^2) + 1) for q = r/h <= 1/2,
 * 2 s (1 - q)^3 up to 1, s = 8 / (pi h^3). The rest lattice is cubic with the particle spacing as edge. */
#ifndef HC_REST_LATTICE_H
#define HC_REST_LATTICE_H

/* Sum of W h^3 over the rest lattice seen from one of its points, its own share included; 1 /
 * spacing_over_h^3 to 3e-5 at a spacing of h/2. Particle mass = rest density * mass factor * h^3 / this.
 * `spacing_over_h` from 1/64 to below 1. Local; the same bits everywhere. */
double hc_setup_rest_lattice_sum(double spacing_over_h);

/* The wall factor gamma in V_b = gamma / sum of W over boundary particles (own share included) for which a
 * resting lattice one spacing from a flat square lattice of boundary particles has exactly the rest density:
 * gamma = (1 - S_half / S) S_plane0 / S_plane1, with S the sum above, S_half that over the half lattice seen
 * from its first layer, S_plane0 and S_plane1 those over a plane lattice through the point and one spacing
 * away. Exact only for flat walls: edges come out at 0.994 of the rest density, corners at 0.986 (spacing
 * h/2). Range as above. */
double hc_setup_wall_factor(double spacing_over_h);

/* The wall density, sum of V_b W, on the wetted surface of a flat wall with that factor: half a spacing from
 * a square lattice of boundary particles, over one of them. About 0.49 with the computed factor at a spacing
 * of h/2. */
double hc_setup_contact_limit(double spacing_over_h, double factor);

/* The wall density of a lattice a spacing from a flat wall with that factor: 0.15 with the computed one. */
double hc_setup_flat_wall(double spacing_over_h, double factor);

/* The most wall density that fluid may start with: what it has in a right corner a spacing from three walls,
 * or on the wetted surface, and a little more. */
double hc_setup_start_limit(double spacing_over_h, double factor);

/* The share of a flat wall, filled with the rest lattice, in the density of its own outermost layer: what
 * fluid at rest on it leaves. 0.85 at a spacing of h/2. Range as above. */
double hc_setup_wall_share(double spacing_over_h);

/* The largest eigenvalue of what a whole correction of the density solver does to the errors, over the waves
 * on the rest lattice: |sum sin(k.x) grad W|^2 / sum |grad W|^2. 2.8 at a spacing of h/2, 7.5 at h/3. */
double hc_setup_rest_lattice_eigenvalue(double spacing_over_h);

/* Sum of |grad W|^2 h^8 over the rest lattice seen from one of its points: of the prototype particle with a
 * filled neighbourhood (Ihmsen et al. 2010, eq. 4), whose gradients themselves cancel. Range as above. */
double hc_setup_rest_lattice_gradient(double spacing_over_h);

/* Sum of W h^3 over a half space of the rest lattice whose first layer is `distance` support radii away, each
 * layer spread out evenly: times (spacing/h)^3, the share of the rest density that a wall adds (Harada et al.
 * 2007). Range as above. */
double hc_setup_half_space(double spacing_over_h, double distance);

#endif
