/* What a scene says of its fluid as a whole. All local. */
#ifndef HC_SETUP_FLUID_H
#define HC_SETUP_FLUID_H

#include "scene/scene.h"

/* The size of gravity, m/s2. */
double hc_setup_gravity(const hc_scene *scene);

/* The same with the largest that the central force pulls a block by. */
double hc_setup_pull(const hc_scene *scene);

/* Of all blocks together, along gravity, m; 0 without gravity. */
double hc_setup_fluid_height(const hc_scene *scene);

/* Of the tallest block, along gravity, m; without gravity the sum of its edges. */
double hc_setup_block_height(const hc_scene *scene);

/* The largest speed of fluid at the start and of what emitters let in, m/s. */
double hc_setup_start_speed(const hc_scene *scene);

/* Sound speed of fluid that is weakly compressible, m/s; 0 where the scene says nothing to estimate it by. */
double hc_setup_wave_speed(const hc_scene *scene);

/* Sound speed of the artificial viscosity, m/s; 0 for other viscosities. */
double hc_setup_sound_speed(const hc_scene *scene);

/* The kinematic viscosity that bounds the time step, m2/s; 0: none. */
double hc_setup_kinematic_viscosity(const hc_scene *scene);

#endif
