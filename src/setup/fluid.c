#include "fluid.h"

#include "setup/source.h"

#include <math.h>

double hc_setup_gravity(const hc_scene *scene) {
  double square = 0.0;
  for (int axis = 0; axis < 3; axis++) square += scene->gravity[axis] * scene->gravity[axis];
  return sqrt(square);
}

double hc_setup_pull(const hc_scene *scene) {
  const double rate = scene->central_force.rate;
  double farthest = 0.0;
  for (int block = 0; block < scene->fluid.block_count && rate > 0.0; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double square = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const double centre = scene->central_force.center[axis],
                   off = fmax(fabs(box.min[axis] - centre), fabs(box.max[axis] - centre));
      square += off * off;
    }
    farthest = fmax(farthest, square);
  }
  return hc_setup_gravity(scene) + rate * rate * sqrt(farthest);
}

double hc_setup_fluid_height(const hc_scene *scene) {
  const double gravity = hc_setup_gravity(scene);
  double low = INFINITY, high = -INFINITY;
  for (int block = 0; block < scene->fluid.block_count && gravity > 0.0; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double ends[2] = {0.0, 0.0};
    for (int axis = 0; axis < 3; axis++) {
      const double down = scene->gravity[axis] / gravity;
      ends[down < 0.0] += down * box.min[axis];
      ends[down >= 0.0] += down * box.max[axis];
    }
    low = fmin(low, ends[0]);
    high = fmax(high, ends[1]);
  }
  return high > low ? high - low : 0.0;
}

double hc_setup_block_height(const hc_scene *scene) {
  const double gravity = hc_setup_gravity(scene);
  double height = 0.0;
  for (int block = 0; block < scene->fluid.block_count; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double extent = 0.0;
    for (int axis = 0; axis < 3; axis++)
      extent +=
          (box.max[axis] - box.min[axis]) * (gravity > 0.0 ? fabs(scene->gravity[axis]) / gravity : 1.0);
    height = fmax(height, extent);
  }
  return height;
}

/* Sound speed of the artificial viscosity if the scene names none: ten times the speed of a fall over the
 * fluid's height, which keeps a weakly compressible fluid within 1 %. */
static double default_sound_speed(const hc_scene *scene) {
  const double gravity = hc_setup_gravity(scene);
  return 10.0 * sqrt(2.0 * (gravity > 0.0 ? gravity : 1.0) * hc_setup_block_height(scene));
}

/* The largest speed at which emitters let fluid in. */
static double emitted_speed(const hc_scene *scene) {
  double speed = 0.0;
  for (int k = 0; k < scene->fluid.emitter_count; k++) {
    const hc_scene_emitter *emitter = &scene->fluid.emitters[k];
    const double area = emitter->form == HC_EMITTER_DISC
                            ? 3.14159265358979323846 * emitter->radius * emitter->radius
                            : emitter->size[0] * emitter->size[1];
    speed = fmax(speed, fmax(emitter->speed, emitter->rate / area));
  }
  return speed;
}

/* The largest speed of a block at the start, in one of the corners of the box around it. */
static double block_speed(const hc_block *block) {
  double gradient[3][3], largest = 0.0;
  const hc_box box = hc_source_block_bounds(block);
  hc_source_block_gradient(block, gradient);
  for (int corner = 0; corner < 8; corner++) {
    double square = 0.0;
    for (int a = 0; a < 3; a++) {
      double v = block->velocity[a];
      for (int b = 0; b < 3; b++)
        v += gradient[a][b] * ((corner >> b & 1 ? box.max[b] : box.min[b]) - block->velocity_center[b]);
      square += v * v;
    }
    largest = fmax(largest, sqrt(square));
  }
  return largest + (block->flow.type == HC_FLOW_NONE ? 0.0 : block->flow.speed);
}

double hc_setup_start_speed(const hc_scene *scene) {
  double largest = 0.0;
  for (int k = 0; k < scene->fluid.block_count; k++)
    largest = fmax(largest, block_speed(&scene->fluid.blocks[k]));
  return fmax(largest, emitted_speed(scene));
}

double hc_setup_wave_speed(const hc_scene *scene) {
  if (scene->solver.sound_speed > 0.0) return scene->solver.sound_speed;
  const double height = fmax(hc_setup_fluid_height(scene), hc_setup_block_height(scene));
  const double speed = fmax(sqrt(2.0 * hc_setup_pull(scene) * height), hc_setup_start_speed(scene));
  return speed / sqrt(scene->solver.density_fluctuation);
}

double hc_setup_sound_speed(const hc_scene *scene) {
  if (scene->fluid.viscosity.model != HC_VISCOSITY_ARTIFICIAL) return 0.0;
  if (scene->fluid.viscosity.sound_speed > 0.0) return scene->fluid.viscosity.sound_speed;
  return fmax(default_sound_speed(scene), 10.0 * emitted_speed(scene));
}

double hc_setup_kinematic_viscosity(const hc_scene *scene) {
  const double coefficient = scene->fluid.viscosity.coefficient;
  if (scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR) return coefficient;
  if (scene->fluid.viscosity.model == HC_VISCOSITY_SMAGORINSKY)
    return scene->fluid.kinematic_viscosity; /* of eddies a step takes no more than it bears */
  /* artificial: what it amounts to in three dimensions, alpha h c / 10 (Monaghan 2005) */
  return 0.1 * coefficient * scene->support_radius * hc_setup_sound_speed(scene);
}
