/* The scene: what a user asks for, as plain data. Filled by the reader (reader.h) from YAML through the
 * parameter table (params.def); every other room takes what it needs from here by value or const pointer.
 *
 * Lengths in metres, times in seconds, SI throughout, in the scene's own frame. */
#ifndef HC_SCENE_H
#define HC_SCENE_H

#include <stdbool.h>
#include <stdint.h>

enum { HC_NAME_LENGTH = 128, HC_FILE_LENGTH = 512, HC_CHECKSUM_LENGTH = 24, HC_MAX_SNAPSHOT_FIELDS = 16 };

typedef struct hc_box {
  double min[3], max[3];
} hc_box;

/* A turn about the middle: right-handed about `axis`, of any length. */
typedef struct hc_rotation {
  double axis[3];
  double angle; /* degrees */
} hc_rotation;

typedef struct hc_cylinder {
  double base[3]; /* middle of its bottom */
  double axis[3]; /* from bottom to top, of any length */
  double radius, length;
} hc_cylinder;

typedef struct hc_sphere {
  double center[3];
  double radius;
} hc_sphere;

/* A file of triangles: scaled, then turned about its origin, then moved. */
typedef struct hc_mesh_input {
  char file[HC_FILE_LENGTH]; /* with its whole path, once it is loaded */
  char checksum[HC_CHECKSUM_LENGTH];
  double scale; /* m for each unit of the file */
  hc_rotation rotation;
  double translation[3];
  bool closed; /* walls; a block always is */
} hc_mesh_input;

/* What a profile of pairs (r, z) makes, turned about an axis. */
typedef struct hc_revolution {
  double base[3]; /* where r and z are 0 */
  double axis[3]; /* along which z grows, of any length */
  double (*profile)[2];
  int profile_count;
  bool closed; /* walls; a block always is */
} hc_revolution;

/* What is made of a mesh or a revolution when the scene is read, see setup/meshes.h; freed with the scene,
 * or before. */
typedef struct hc_made_surface {
  struct hc_surface *surface; /* null: not made */
  void (*free)(struct hc_surface *surface);
} hc_made_surface;

/* What is read of a rest state, see setup/rest_states.h; freed likewise. */
typedef struct hc_made_rest_state {
  struct hc_rest_state *state; /* null: not read */
  void (*free)(struct hc_rest_state *state);
} hc_made_rest_state;

/* Which of the shapes a block or wall has; the others are zero. */
typedef enum hc_form {
  HC_FORM_BOX,
  HC_FORM_CYLINDER,
  HC_FORM_SPHERE,
  HC_FORM_MESH,
  HC_FORM_REVOLUTION,
  HC_FORM_PLANE
} hc_form;

typedef enum hc_flow_type { HC_FLOW_NONE, HC_FLOW_TAYLOR_GREEN, HC_FLOW_STANDING_WAVE } hc_flow_type;

/* An initial velocity field, added to a block's constant velocity.
 * taylor_green: u = -U cos(2 pi x/L) sin(2 pi y/L), v = U sin(2 pi x/L) cos(2 pi y/L), w = 0.
 * standing_wave: u = U cosh(k z)/sinh(k H) sin(k x), w = -U sinh(k z)/sinh(k H) cos(k x), k = 2 pi/L. */
typedef struct hc_flow {
  hc_flow_type type;
  double speed;  /* U, m/s */
  double length; /* L, m */
  double depth;  /* H, m: standing_wave, whose bed is at z = 0 */
} hc_flow;

typedef struct hc_block {
  hc_form form; /* not a plane */
  hc_box box;
  hc_rotation rotation; /* of the box */
  hc_cylinder cylinder;
  hc_sphere sphere;
  hc_mesh_input mesh;
  hc_revolution revolution;
  hc_made_surface made;
  char rest_state[HC_FILE_LENGTH]; /* the file of what fills it; empty: the lattice does */
  char rest_checksum[HC_CHECKSUM_LENGTH];
  double rest_offset[3]; /* m: where an image of it has its lower corner */
  hc_made_rest_state rest;
  double start;  /* s: when a rest state comes */
  bool replaces; /* takes what is in the shape out first */
  double velocity[3];
  double velocity_gradient[3][3]; /* 1/s: of component a along axis b */
  double angular_velocity[3];     /* rad/s */
  double velocity_center[3];      /* m: where these two add nothing */
  hc_flow flow;
} hc_block;

/* How rest states fit themselves to what they meet: Carensac et al. 2023, section 3. */
typedef struct hc_scene_rest {
  double distance;                   /* spacings: from a wetted surface, at least */
  double early_density;              /* share of the rest density: what walls and other fluid may give */
  double target;                     /* the same: the mean density at which the selection ends */
  double regulator;                  /* R_ssr; 0: the threshold falls by `step` each time */
  double step;                       /* of the rest density: what the threshold falls by, at least */
  bool protection;                   /* of who is too dense only by a denser neighbour */
  int steps;                         /* damped ones, at most */
  double damping_start, damping_end; /* shares of the velocity that a step takes */
  double speed_max, speed_avg;       /* half spacings a step: slower than both is at rest */
  double density_error_avg;          /* of damped steps; dfsph */
  int iterations;                    /* of each of them, at most; dfsph */
} hc_scene_rest;

typedef enum hc_emitter_form { HC_EMITTER_DISC, HC_EMITTER_RECTANGLE } hc_emitter_form;

/* Where fluid comes in: layers of particles, a spacing apart, at a speed along a direction. */
typedef struct hc_scene_emitter {
  hc_emitter_form form;
  double position[3];    /* m: the middle of the opening */
  double direction[3];   /* of the flow, of any length */
  double radius;         /* disc: m */
  double size[2];        /* rectangle: m, along its tangents, which are a plane's */
  double speed, rate;    /* m/s; m3/s: the other is 0 */
  double start, stop;    /* s; stop 0: never */
  int64_t max_particles; /* 0: any number */
  double clearance;      /* spacings */
} hc_scene_emitter;

typedef enum hc_inside { HC_INSIDE_FLUID, HC_INSIDE_SOLID } hc_inside;

/* Bits of hc_wall.open: the faces of a box, along its own axes if it is turned, or the ends of a cylinder
 * that are not there. */
enum {
  HC_FACE_MINUS_X = 1,
  HC_FACE_PLUS_X = 2,
  HC_FACE_MINUS_Y = 4,
  HC_FACE_PLUS_Y = 8,
  HC_FACE_MINUS_Z = 16,
  HC_FACE_PLUS_Z = 32,
  HC_FACE_BASE = 64,
  HC_FACE_TOP = 128,
  HC_FACES_OF_BOX = 63,
  HC_FACES_OF_CYLINDER = 192
};

typedef enum hc_wall_motion_type {
  HC_WALL_STANDS,
  HC_WALL_CONSTANT,
  HC_WALL_COSINE,
  HC_WALL_TABLE
} hc_wall_motion_type;

typedef enum hc_interpolation { HC_INTERPOLATION_LINEAR, HC_INTERPOLATION_SMOOTH } hc_interpolation;

/* A row of a table: where the wall is then, from where the scene puts it. */
typedef struct hc_motion_point {
  double time;     /* s since the motion's start */
  double shift[3]; /* m */
  double angle;    /* degrees about the motion's axis */
} hc_motion_point;

/* A prescribed motion: the wall turns about `center` and is shifted; rigid/motion.h says how. */
typedef struct hc_wall_motion {
  hc_wall_motion_type type;
  double velocity[3];             /* constant: m/s */
  double direction[3];            /* cosine: of the shift, of any length */
  double amplitude, speed;        /* cosine: m, or largest m/s; the other is 0 */
  double axis[3], center[3];      /* of the turn; the axis of any length */
  double angle, angular_velocity; /* constant: rad/s; cosine: degrees, or largest rad/s */
  double frequency, phase;        /* cosine: Hz, degrees */
  hc_interpolation interpolation; /* table */
  char file[256];                 /* table: CSV, beside the scene; empty once it has been read */
  hc_motion_point *points;        /* table: times ascending */
  int point_count;
  double start, stop; /* s; stop 0: never */
} hc_wall_motion;

typedef enum hc_scene_friction {
  HC_SCENE_FRICTION_NONE,
  HC_SCENE_FRICTION_NO_SLIP,
  HC_SCENE_FRICTION_SMOOTH,
  HC_SCENE_FRICTION_ROUGH
} hc_scene_friction;

/* A wall's surface is the wetted surface: boundary samples lie half a spacing outside the fluid's side of it.
 */
typedef struct hc_wall {
  hc_form form;
  char name[HC_NAME_LENGTH];
  hc_box box; /* the container's inner or the solid's outer surface, as the cylinder and the sphere */
  hc_rotation rotation; /* of the box */
  hc_cylinder cylinder;
  hc_sphere sphere;
  hc_mesh_input mesh;
  hc_revolution revolution;
  hc_made_surface made;
  hc_inside inside; /* not of a plane, nor of what is not closed: what is within */
  unsigned open;    /* box, cylinder: HC_FACE_* bits */
  double point[3];  /* plane: the rectangle's centre */
  double normal[3]; /* plane: into the fluid; unit length after reading */
  double size[2];   /* plane: edge lengths along its two tangents */
  hc_wall_motion motion;
  double surface_velocity[3]; /* m/s: of a current along it, for what absorption lets in */
  hc_scene_friction friction_law;
  double roughness; /* rough: k_s, m */
} hc_wall;

/* Bits of hc_scene_body.locked: what a body cannot do, along the scene's axes. */
enum {
  HC_LOCKED_X = 1,
  HC_LOCKED_Y = 2,
  HC_LOCKED_Z = 4,
  HC_LOCKED_ROLL = 8,
  HC_LOCKED_PITCH = 16,
  HC_LOCKED_YAW = 32
};

typedef enum hc_force_frame { HC_FORCE_WORLD, HC_FORCE_BODY } hc_force_frame;

/* A pull on a body. */
typedef struct hc_scene_force {
  double force[3];      /* N */
  double at[3];         /* m: where the body has the point as it starts, with which it goes on */
  hc_force_frame frame; /* body: the force turns with it */
  double start, stop;   /* s; stop 0: never */
} hc_scene_force;

typedef enum hc_mooring_type { HC_MOORING_LINE, HC_MOORING_SPRING } hc_mooring_type;

/* A line or a spring from a body to a fixed point. */
typedef struct hc_scene_mooring {
  hc_mooring_type type;      /* a line only pulls */
  double at[3];              /* m: as of a force */
  double anchor[3];          /* m */
  double length;             /* m: at rest; 0: as long as it is at the start */
  double stiffness, damping; /* N/m, N s/m */
} hc_scene_mooring;

/* A rigid body that the fluid moves. Its surface counts as a wall behind those of the boundary. */
typedef struct hc_scene_body {
  hc_wall surface;              /* name, shape and friction; what is inside is solid */
  double density, mass;         /* kg/m3, kg: one is given, the other 0 */
  double center_of_mass[3];     /* m: where the shape is; */
  double gyration[3];           /* m: radii of gyration about the axes through it; 0: of the even shape */
  double position[3];           /* m: of the centre of mass at the start */
  hc_rotation turned;           /* at the start, about the centre of mass */
  double velocity[3];           /* m/s: of the centre of mass at the start */
  double angular_velocity[3];   /* rad/s */
  unsigned locked;              /* HC_LOCKED_* bits */
  double friction, restitution; /* of contact with walls and bodies */
  hc_scene_force *forces;
  int force_count;
  hc_scene_mooring *moorings;
  int mooring_count;
} hc_scene_body;

/* A wall in front of which water comes in and goes out, so that waves are taken up: Carensac et al. 2023,
 * section 4.2. */
typedef struct hc_scene_absorption {
  char wall[HC_NAME_LENGTH]; /* of boundary.walls */
  double ocean_height;       /* m: of the water outside, against gravity from the scene's origin */
  double inflow_distance;    /* half spacings: a place with fluid nearer is taken */
  double inflow_density;     /* of the rest density: what a particle there may come to; 0: none comes in */
  double outflow_distance;   /* support radii: what is higher than the ocean and nearer goes; 0: none */
} hc_scene_absorption;

/* A world that goes along with a body: Carensac et al. 2023, section 4.1. */
typedef struct hc_scene_window {
  char follow[HC_NAME_LENGTH]; /* the body's name; empty: there is no window */
  char wall[HC_NAME_LENGTH];   /* the wall around it, the only one */
  double trigger;              /* support radii: how far the body may get before the window goes along */
  double old_distance;         /* half spacings: fluid nearer to where the wall was is renewed, */
  double new_distance;         /* support radii: and to where it comes to */
  double target;               /* of the rest density: fluid.rest.target where old and new water meet */
} hc_scene_window;

typedef enum hc_gauge_type {
  HC_GAUGE_HEIGHT,
  HC_GAUGE_FRONT,
  HC_GAUGE_PRESSURE,
  HC_GAUGE_FLOW,
  HC_GAUGE_FORCE,
  HC_GAUGE_ENERGY,
  HC_GAUGE_VOLUME,
  HC_GAUGE_DENSITY,
  HC_GAUGE_BODY,
  HC_GAUGE_MOORING
} hc_gauge_type;

/* What a run measures; gauges/gauges.h says how. */
typedef struct hc_scene_gauge {
  char name[HC_NAME_LENGTH];
  hc_gauge_type type;
  unsigned axis;             /* front, flow: one HC_FACE_* bit; pressure on a wall: 0 or that of the face */
  double at[3];              /* height: x and y; pressure: the point; force: the moment's point */
  hc_box box;                /* front, energy, volume: only what is within; flow: the rectangle */
  char wall[HC_NAME_LENGTH]; /* pressure, force: the name of a wall or body; pressure: may be empty */
  char body[HC_NAME_LENGTH]; /* body, mooring: the body's name */
  int mooring;               /* its number among the body's */
  double radius;             /* pressure: of what counts around the point, m; 0: the support radius */
  double mean_over;          /* pressure, flow, force: s; 0: since the last row */
} hc_scene_gauge;

typedef enum hc_viscosity_model {
  HC_VISCOSITY_NONE,
  HC_VISCOSITY_XSPH,       /* coefficient: dimensionless */
  HC_VISCOSITY_ARTIFICIAL, /* coefficient: alpha of Monaghan 1992; sound_speed */
  HC_VISCOSITY_LAMINAR,    /* coefficient: kinematic viscosity, m2/s */
  HC_VISCOSITY_SMAGORINSKY /* coefficient: C_s, the mixing length in spacings */
} hc_viscosity_model;

typedef enum hc_tension_model { HC_TENSION_NONE, HC_TENSION_BECKER2007 } hc_tension_model;
typedef enum hc_boundary_method {
  HC_BOUNDARY_AKINCI2012,
  HC_BOUNDARY_IHMSEN2010,
  HC_BOUNDARY_BECKER2009,
  HC_BOUNDARY_HARADA2007
} hc_boundary_method;
typedef enum hc_wall_density { HC_WALL_DENSITY_SUM, HC_WALL_DENSITY_SQUARED } hc_wall_density;
typedef enum hc_solver_method { HC_SOLVER_DFSPH, HC_SOLVER_PCISPH, HC_SOLVER_WCSPH } hc_solver_method;
typedef enum hc_density_correction { HC_CORRECTION_NONE, HC_CORRECTION_SHEPARD } hc_density_correction;
typedef enum hc_pressure_solve { HC_PRESSURE_SOLVE_FAST, HC_PRESSURE_SOLVE_PAPER } hc_pressure_solve;
typedef enum hc_time_control {
  HC_TIME_CONSTANT,
  HC_TIME_CFL,
  HC_TIME_ADAPTIVE,
  HC_TIME_GLOBAL,
  HC_TIME_INDIVIDUAL
} hc_time_control;
typedef enum hc_individual_steps { HC_STEPS_POWER_OF_TWO, HC_STEPS_RAW } hc_individual_steps;
typedef enum hc_leaving { HC_LEAVING_ERROR, HC_LEAVING_REMOVE } hc_leaving;
typedef enum hc_decomposition { HC_DECOMPOSITION_SLABS, HC_DECOMPOSITION_METIS } hc_decomposition;
typedef enum hc_rebalance { HC_REBALANCE_NONE, HC_REBALANCE_SLABS, HC_REBALANCE_METIS } hc_rebalance;

typedef struct hc_iterations {
  int min, max;
} hc_iterations;

/* Of sqrt(h/F) and h/v for the time step, and of the average density error allowed. */
typedef struct hc_time_bounds {
  double force, velocity, error_max, error_avg;
} hc_time_bounds;

/* The adaptive time step; stepping/adaptive.h says what they do. */
typedef struct hc_time_adaptive {
  double change;
  hc_time_bounds grow, shrink;
  struct {
    double error_rise; /* fraction of the rest density; 0 = 5 times the average density error allowed */
    double velocity;
  } shock;
  struct {
    double force, velocity, share;
    int most;
  } restart;
  struct {
    double velocity, depth;
  } first;
} hc_time_adaptive;

typedef struct hc_scene {
  char name[HC_NAME_LENGTH];
  double particle_spacing;
  double support_ratio, support_radius; /* the radius in particle spacings, and in m */
  double gravity[3];
  struct {
    double center[3]; /* m */
    double rate;      /* rad/s: the acceleration is rate^2 towards the centre, a metre off it; 0: none */
  } central_force;
  double end_time;
  int64_t origin_cells[3]; /* the scene's origin lies at this corner of the cell grid */

  struct {
    bool periodic[3];
    double min[3], max[3];               /* along periodic axes: the period; elsewhere unused */
    double limits_min[3], limits_max[3]; /* of the world, along open axes; max <= min: computed */
    hc_leaving leaving;                  /* what particles beyond do */
  } domain;

  struct {
    double rest_density;
    double kinematic_viscosity; /* m2/s: what friction at walls and smagorinsky go by */
    struct {
      hc_viscosity_model model;
      double coefficient;
      double sound_speed; /* artificial: m/s; 0 = 10 sqrt(2 |g| H) with H the fluid's height at the start */
    } viscosity;
    struct {
      hc_tension_model model;
      double coefficient; /* kappa, m3/s2 */
    } surface_tension;
    double mass_factor; /* particle mass over the lattice's; below 1 under-fills a closed periodic domain */
    double disorder;    /* largest random shift off the lattice along each axis, in spacings */
    int seed;           /* which random shifts */
    int settle_steps;   /* before the start: gravity and pressure without momentum */
    hc_scene_rest rest;
    hc_block *blocks;
    int block_count;
    hc_scene_emitter *emitters;
    int emitter_count;
  } fluid;

  struct {
    hc_boundary_method method;
    double volume_factor; /* 0 = computed */
    hc_wall_density wall_density;
    int layers;                     /* of samples; 0 = what the method asks for */
    bool contact;                   /* hold particles that the wall's pressure does not stop */
    hc_scene_friction friction_law; /* of walls that name none, */
    double roughness;               /* and k_s of rough ones, m */
    bool depth_pressure;
    double friction;   /* share of the tangential velocity that stays; 1 = free slip */
    double elasticity; /* share of the normal velocity that returns */
    hc_wall *walls;
    int wall_count;
  } boundary;

  hc_scene_body *bodies;
  int body_count;

  hc_scene_absorption *absorptions;
  int absorption_count;

  hc_scene_window window;

  struct {
    hc_solver_method method;
    double density_error_avg; /* fraction of the rest density */
    double density_error_max; /* the same; 0 = 10 times density_error_avg */
    hc_density_correction density_correction;
    int release_steps;
    double divergence_error; /* fraction of the rest density per step */
    hc_iterations density_iterations, divergence_iterations;
    double warm_start; /* share of the last step's pressure taken over, 0 to 1 */
    double relaxation; /* of each correction, above 0 to 1 */
    hc_pressure_solve pressure_solve;
    bool gap_rule;
    int min_divergence_neighbors; /* fewer: the divergence solver leaves the particle alone */
    bool negative_pressure;       /* correct expansion too (closed periodic flows) */
    double density_fluctuation;   /* wcsph: permitted on average, fraction of the rest density */
    double sound_speed;           /* wcsph: m/s; 0 = by density_fluctuation */
  } solver;

  struct {
    hc_time_control control;
    double size;            /* constant */
    double factor;          /* cfl: step <= factor * particle_spacing / v_max */
    double max;             /* but constant */
    double velocity, force; /* global, individual: lambda of h/v, sqrt(h/F) */
    hc_individual_steps steps;
    bool blocks;   /* individual: cells and lists last for several sub-steps */
    double margin; /* individual: of cells, in support radii */
    double min;    /* floor; 0 = a share of the largest step */
    hc_time_adaptive adaptive;
  } time_step;

  struct {
    double snapshots_every; /* s */
    char snapshot_fields[HC_MAX_SNAPSHOT_FIELDS][32];
    int snapshot_field_count;
    double checkpoints_every_wall; /* s; 0: only at the end or when stopped */
    int checkpoints_every_steps;   /* 0: by the clock only */
    int checkpoints_keep;
    double gauges_every; /* s */
    hc_scene_gauge *gauges;
    int gauge_count;
  } output;

  struct {
    hc_decomposition decomposition;
    hc_rebalance rebalance;
    double rebalance_above; /* imbalance (largest over mean work) that starts a rebalance */
    int rebalance_at;       /* hidden: forces a rebalance at this step; 0 = never */
    int rebalance_every;    /* hidden: forces one whenever so many steps are done; 0 = never */
    int ranks_per_host;     /* hidden: as if so many shared a host; 0 = as the machines say */
  } parallel;

  struct { /* hidden: faults after so many steps, to test what they do; 0 = never */
    int nan_at, kick_at;
    int shock_at, shock_again; /* a shock that many times more */
  } faults;
} hc_scene;

/* What a gauge's columns are called behind its own name, null-ended; none: one column that is called as the
 * gauge. */
const char *const *hc_scene_gauge_parts(hc_gauge_type type);

/* What a scene means by its errors: with adaptive steps 10 and 5 times the average error allowed (Ihmsen et
 * al. 2010, section 3.3), where it does not say. */
static inline double hc_scene_density_error_max(const hc_scene *scene) {
  const double given = scene->solver.density_error_max;
  return given > 0.0 ? given : 10.0 * scene->solver.density_error_avg;
}
static inline double hc_scene_shock_rise(const hc_scene *scene) {
  const double given = scene->time_step.adaptive.shock.error_rise;
  return given > 0.0 ? given : 5.0 * scene->solver.density_error_avg;
}

/* Walls and the surfaces of bodies in one numbering, the bodies' behind the walls': how many there are, and
 * one of them. */
int hc_scene_surfaces(const hc_scene *scene);
const hc_wall *hc_scene_surface(const hc_scene *scene, int number);

/* The number of the one with that name; -1: there is none, as for an empty name. */
int hc_scene_surface_named(const hc_scene *scene, const char *name);

/* Is it the surface of a body? Does it stand still for ever? */
bool hc_scene_is_body(const hc_scene *scene, int number);
bool hc_scene_stands(const hc_scene *scene, int number);

/* Is there a window? */
bool hc_scene_has_window(const hc_scene *scene);

void hc_scene_free(hc_scene *scene);

/* Frees what was made of meshes and revolutions, which nothing asks for once the particles are there. */
void hc_scene_free_surfaces(hc_scene *scene);

#endif
