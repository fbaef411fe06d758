/* Halocline inside another program: a scene becomes a run that the program steps, looks at and writes out.
 *
 *   hc_session_start -> hc_run_from_file or hc_run_from_text -> hc_run_step ... -> hc_run_free ->
 * hc_session_end
 *
 * "Collective": every rank of the session calls it, in the same order and with the same arguments unless said
 * otherwise. Its status and message are agreed: the same on every rank. "Local": any rank may call it alone.
 * Null where a pointer is not said to be optional, and handles that were freed, are errors of the program and
 * not looked for.
 *
 * Functions that can fail return a status and, then, put one message into `error`, which may be null. The
 * values of hc_status say what kind of failure it was. Broken invariants and lack of memory abort the
 * process and, while a session lives, all processes of MPI_COMM_WORLD; so do exit, SIGABRT and, unless the
 * program has handlers of its own, SIGSEGV, SIGBUS, SIGFPE and SIGILL.
 *
 * Units are SI; coordinates are those of the scene. Several sessions and runs may live side by side, in one
 * thread. HDF5's own printing of errors is turned off by the first snapshot, since messages come as text. */
#ifndef HALOCLINE_HALOCLINE_H
#define HALOCLINE_HALOCLINE_H

#include "halocline/error.h"
#include "halocline/export.h"
#include "halocline/version.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The ranks that share runs. */
typedef struct hc_session hc_session;

/* Starts a session, owned by the caller (hc_session_end). `communicator`, optional: the Fortran handle of an
 * MPI communicator, const int handle = MPI_Comm_c2f(comm); it is duplicated, and stays the caller's. Null:
 * all ranks of MPI_COMM_WORLD, and MPI is started first if it is not running. Collective over the
 * communicator. HC_BAD_INPUT: MPI has ended, or is not running though a communicator is given; a handle that
 * is none. On failure *session is null. */
HC_PUBLIC hc_status hc_session_start(const int *communicator, hc_session **session, hc_error *error);

/* Ends a session after its runs were freed; ends MPI if this session started it (then it must be the last).
 * Null is let pass. Collective. */
HC_PUBLIC void hc_session_end(hc_session *session);

/* This process's number in the session, from 0, and how many there are. Local. */
HC_PUBLIC int hc_session_rank(const hc_session *session);
HC_PUBLIC int hc_session_size(const hc_session *session);

/* A scene and its particles at a moment. */
typedef struct hc_run hc_run;

/* Makes a run from a scene file or from the text of one (YAML; `halocline keys` lists the keys), with
 * `override_count` overrides "path.to.key=value" over it, in their order; none: null and 0. The particles are
 * made and spread over the ranks. What rank 0 says counts: other ranks' path, text and overrides are not
 * looked at and may be null and 0. The run is the caller's (hc_run_free), and must go before its session; all
 * arguments may go after the call. Collective. HC_BAD_INPUT: no such file, or a bad scene; the message then
 * tells all its mistakes, with lines. On failure *run is null. */
HC_PUBLIC hc_status hc_run_from_file(hc_session *session, const char *path, const char *const *overrides,
                                     int override_count, hc_run **run, hc_error *error);
HC_PUBLIC hc_status hc_run_from_text(hc_session *session, const char *text, const char *const *overrides,
                                     int override_count, hc_run **run, hc_error *error);

/* Null is let pass. Collective. */
HC_PUBLIC void hc_run_free(hc_run *run);

/* Advances by one time step, which the scene's time_step chooses; the last one ends at its end_time, and
 * after that there is nothing to step: HC_BAD_INPUT. HC_FAILED: the simulation diverged, or a
 * particle left the world and domain.leaving is error: the message names particle, place and likely cause,
 * and the run can be written as a snapshot or freed, nothing else. With domain.leaving: remove, particles
 * that have left are taken out as a step begins, and `fluid` falls. With time_step.control: adaptive a shock
 * takes back the step before it too: then step and time may be no later than before the call. Collective. */
HC_PUBLIC hc_status hc_run_step(hc_run *run, hc_error *error);

/* What is known of a run at its moment; the same on every rank but for the own counts. */
typedef struct hc_run_facts {
  int64_t step;                    /* steps done */
  double time;                     /* s */
  double dt;                       /* s: of the last step; 0 before the first */
  bool done;                       /* end_time is reached */
  double end_time;                 /* s */
  double particle_spacing;         /* m */
  double support_radius;           /* m */
  double rest_density;             /* kg/m3 */
  double particle_mass;            /* kg: of every fluid particle */
  int64_t fluid, boundary;         /* particles on all ranks */
  int64_t own_fluid, own_boundary; /* particles on this rank */
  double kinetic_energy;           /* J: of the fluid; NaN before the first step, as are the next two */
  double potential_energy;         /* J: of the fluid in gravity, 0 at the scene's origin */
  double density_error;            /* 1: mean compression that the solver left, over the rest density */
  double v_max;                    /* m/s: the fastest fluid particle */
  int density_iterations, divergence_iterations; /* of the last step; 0 before the first */
} hc_run_facts;

/* Local. */
HC_PUBLIC hc_run_facts hc_run_facts_of(const hc_run *run);

/* Arrays of the caller's for this rank's particles; a null one is left out. */
typedef struct hc_run_particles {
  double *position; /* [room][3], m, scene coordinates; within the period along periodic axes */
  double *velocity; /* [room][3], m/s; 0 for boundary particles */
  float *density;   /* [room], kg/m3: in the step that led here; 0 for boundary particles */
  float *pressure;  /* [room], Pa: likewise */
  uint64_t *id;     /* [room], stays with a particle from rank to rank; unique in the run */
} hc_run_particles;

typedef enum hc_run_kind { HC_RUN_FLUID, HC_RUN_BOUNDARY } hc_run_kind;

/* Copies this rank's particles of a kind. Each has one owner; owner and order change from step to step.
 * `room`: particles that each array holds; HC_BAD_INPUT if it is below own_fluid or own_boundary, then
 * nothing is copied. Local. */
HC_PUBLIC hc_status hc_run_get(const hc_run *run, hc_run_kind kind, const hc_run_particles *particles,
                               int64_t room, hc_error *error);

/* Writes DIRECTORY/snapshots/snap_NNNNNN.hdf, NNNNNN counting this run's snapshots from 0, over an older one
 * of that name, and enters it in snapshots/run.hdf.series. Fields: the scene's output.snapshots.fields. The
 * directory is made, with its parents. What rank 0 says counts: other ranks' directory may be null.
 * Collective. HC_IO_FAILED: it cannot be written; the run goes on. */
HC_PUBLIC hc_status hc_run_snapshot(hc_run *run, const char *directory, hc_error *error);

#ifdef __cplusplus
}
#endif
#endif
