/* A simulation with its files, while it runs: what the parts of `halocline run` share. run.c steps and tells,
 * job_files.c opens, writes and closes, job_restart.c saves and goes on. */
#ifndef HC_JOB_H
#define HC_JOB_H

#include "base/warnings.h"
#include "explain.h"
#include "gauges/gauges.h"
#include "io/checkpoint.h"
#include "io/log.h"
#include "io/progress.h"
#include "io/tables.h"
#include "simulation/simulation.h"

/* What a run is told besides its scene; texts are the caller's. */
typedef struct hc_job_options {
  const char *scene_file;
  const char *const *overrides; /* of the scene's keys, for the log */
  int override_count;
  const char *output;       /* null: out/NAME */
  int64_t steps;            /* stop after so many; negative: at the end time */
  double walltime;          /* s from the launch; 0: no limit */
  bool restart;             /* go on from a checkpoint, */
  const char *restart_file; /* from this one; null: the newest */
  bool force, quiet;        /* overwrite a run; show no progress */
} hc_job_options;

/* What the ranks know of a step only together: one rank's, until it is reduced. */
typedef struct hc_job_load {
  int64_t fluid, active_boundary, work;    /* particles; active ones; ns: sums */
  int64_t work_max, ghosts_max, bytes_max; /* ns; particles; bytes sent: maxima, as what follows */
  int64_t signal;                          /* that a rank has received, 0: none */
  int64_t out_of_time;                     /* --walltime: rank 0's clock says stop */
  int64_t checkpoint_time;                 /* rank 0's clock says it is time for a checkpoint */
  int64_t tables_failed;                   /* rank 0 could not write a row, see hc_job.problem */
  double imbalance;                        /* of work */
} hc_job_load;

/* Counts over the whole run, restarts included: state, though no step reads them. */
typedef struct hc_job_counts {
  int64_t snapshots; /* written, those of the last moment of a stopped run not counted */
  int64_t departed;  /* particles whose leaving was told one by one, then steps in which more left */
  int64_t blocked;   /* particles of emitters that were left out */
  int64_t density_caps, divergence_caps, contacts, compressed_steps, doubts;
  double shortest_step, longest_step; /* s */
  double gauge_time;                  /* s, of the last regular row of gauges.csv; -1: none */
} hc_job_counts;

/* Log, tables and progress write on rank 0 only; zeroed, they do nothing. */
typedef struct hc_job {
  hc_comm *comm;
  const hc_job_options *options;
  const hc_scene *scene;
  hc_warnings *warnings; /* of the scene, and of the checkpoints that were passed over */
  hc_simulation simulation;
  char directory[HC_TEXT_PATH];
  char checkpoint[HC_TEXT_PATH]; /* that the run goes on from; empty: it starts */
  char *changed;                 /* keys that differ harmlessly from the checkpoint's scene; may be null */
  hc_checkpoint_facts written;   /* of the checkpoint */
  bool taken_back;               /* there are checkpoints of later steps */
  int lock;                      /* on the directory, see run_dir.h */
  hc_log log;
  hc_tables tables;
  hc_progress progress;
  hc_explained explained;
  hc_gauges gauges;
  double *gauge_values;
  hc_job_load load;     /* of the last step */
  int64_t bytes_before; /* sent before the step under way */
  hc_error problem;     /* rank 0's with the tables, which all learn with the next step or checkpoint */
  hc_job_counts counts;
  int64_t first_step;                      /* the step that this session started from, */
  double first_time;                       /* and the time, s */
  double particle_steps;                   /* fluid particles summed over the steps of this session */
  double launched;                         /* wall clock, when the program began, before MPI */
  double started;                          /* wall clock, when the steps began */
  double last_checkpoint;                  /* wall clock */
  double checkpoint_seconds, slowest_step; /* s: the last checkpoint, the slowest step of this session */
  bool stopped;                            /* by a signal or --walltime: exit code 75 */
} hc_job;

/* A run of the scene, from its start or a checkpoint to its end or until something stops it. The scene's
 * surfaces are freed once the particles are there. Warnings are the scene's; `launched`: hc_seconds() when
 * the program began. Collective; true if it stopped early, by a signal or --walltime, with a checkpoint.
 * Errors are agreed. */
bool hc_job_run(hc_comm *comm, hc_scene *scene, const hc_job_options *options, hc_warnings *warnings,
                double launched, hc_error *error);

/* Are there no more steps to do, to the end time or --steps? Local. */
bool hc_job_is_over(const hc_job *job);

/* ---- job_files.c ---- */

/* Directory, scene.yaml, log and tables: new, or going on behind what is there. Collective. */
hc_status hc_job_open_files(hc_job *job, hc_error *error);

/* Closes what was opened; its errors count if the run itself went well. Collective. */
void hc_job_close_files(hc_job *job, hc_error *error);

/* What the log says at the start. Local. */
void hc_job_log_start(hc_job *job);

/* What rest states that have just come were made of. Local. */
void hc_job_log_rest(hc_job *job);

/* A row of steps.csv, a row of load.csv, for rank 0; what goes wrong is job->problem. `event`: words joined
 * by
 * '+'. */
void hc_job_add_step_row(hc_job *job, const char *event);
void hc_job_add_load_row(hc_job *job, double wall_seconds, const char *event);

/* After a step that was taken back (see rollback.h): says so in the log, and removes rows, snapshots and
 * readings of steps that are no more. Collective; HC_IO_FAILED, agreed, as for what job->problem holds. */
hc_status hc_job_take_back(hc_job *job, hc_error *error);

/* Timings by stage into timings.json and the log. Collective. */
hc_status hc_job_summarize(hc_job *job, hc_error *error);

/* A density further off the rest density than this share is worth a warning: single particles of a healthy
 * run stay within it. */
#define HC_JOB_MOST_COMPRESSION 0.05

/* ---- job_restart.c ---- */

/* Registers what the job adds to the state of its simulation. Local. */
void hc_job_register(hc_job *job);

/* --restart: finds the newest valid checkpoint, warns of those it passes over, and holds its scene against
 * the job's. job->checkpoint stays empty if there is none at all. Collective. HC_IO_FAILED: none is valid;
 * HC_BAD_INPUT: the scene has changed. */
hc_status hc_job_find_checkpoint(hc_job *job, hc_error *error);

/* Takes the state over from job->checkpoint. Collective; HC_IO_FAILED, agreed. */
hc_status hc_job_read_checkpoint(hc_job *job, hc_error *error);

/* Writes a checkpoint, with the tables on disk before it. Collective; HC_IO_FAILED, agreed, as for what
 * job->problem holds. */
hc_status hc_job_write_checkpoint(hc_job *job, hc_error *error);

/* Rank 0's clock, see hc_job_load. Local. */
bool hc_job_checkpoint_time(const hc_job *job);
bool hc_job_out_of_time(const hc_job *job);

#endif
