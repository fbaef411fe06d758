#include "progress.h"

#include "base/timer.h"

#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

bool hc_progress_on_terminal(FILE *stream) {
  if (!isatty(fileno(stream))) return false;
  if (!getenv("OMPI_COMM_WORLD_SIZE") && !getenv("PMIX_RANK")) return true;
  char path[64];
  struct stat facts;
  snprintf(path, sizeof path, "/proc/%ld/fd/1", (long)getppid());
  if (stat(path, &facts) != 0 || !S_ISCHR(facts.st_mode)) return false;
  const int parent = open(path, O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  const bool terminal = parent >= 0 && isatty(parent);
  if (parent >= 0) close(parent);
  return terminal;
}

void hc_progress_start(hc_progress *progress, FILE *stream, bool terminal, double time, double end_time) {
  memset(progress, 0, sizeof *progress);
  progress->stream = stream;
  progress->terminal = terminal;
  progress->interval = terminal ? 0.2 : 5;
  progress->start = progress->shown = hc_seconds();
  progress->start_time = progress->shown_time = time;
  progress->end_time = end_time;
}

static void format_duration(char out[32], double seconds) {
  if (!(seconds >= 0 && seconds < 1e9))
    snprintf(out, 32, "?");
  else if (seconds < 99.5)
    snprintf(out, 32, "%.0f s", seconds);
  else if (seconds < 5400)
    snprintf(out, 32, "%d min %02d s", (int)seconds / 60, (int)seconds % 60);
  else
    snprintf(out, 32, "%d h %02d min", (int)(seconds / 3600), (int)(seconds / 60) % 60);
}

static int columns(FILE *stream) {
  struct winsize size;
  return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 200;
}

static void show(hc_progress *progress, const hc_progress_sample *sample, double now) {
  const double wall = now - progress->shown;
  if (wall > 0) {
    /* Averages over some seven seconds: steady, yet it follows a run that grows harder. */
    const double fresh = (sample->time - progress->shown_time) / wall, weight = fmin(1, wall / 7);
    progress->rate = progress->rate > 0 ? progress->rate + weight * (fresh - progress->rate) : fresh;
  }
  char left[32], line[512];
  format_duration(left, progress->rate > 0 ? (progress->end_time - sample->time) / progress->rate : NAN);
  const double share = sample->time < progress->end_time ? 100 * sample->time / progress->end_time : 100;
  snprintf(line, sizeof line,
           "%.4f/%.4g s %3.0f%%  step %" PRId64 "  dt %.3g s  iterations %d+%d  density error %.2g%%  "
           "%.3g particles/s  imbalance %.2f  %s left",
           sample->time, progress->end_time, share, sample->step, sample->dt, sample->iterations_density,
           sample->iterations_divergence, 100 * sample->density_error, wall > 0 ? progress->work / wall : 0,
           sample->imbalance, left);
  if (progress->terminal) /* cut to the terminal: a wrapped line cannot be rewritten */
    fprintf(progress->stream, "\r%.*s\033[K", columns(progress->stream) - 1, line);
  else
    fprintf(progress->stream, "%s\n", line);
  fflush(progress->stream);
  progress->shown = now;
  progress->shown_time = sample->time;
  progress->work = 0;
}

void hc_progress_step(hc_progress *progress, const hc_progress_sample *sample) {
  if (!progress->stream) return;
  progress->work += (double)sample->particles;
  progress->total_work += (double)sample->particles;
  const double now = hc_seconds();
  if (now - progress->shown >= progress->interval) show(progress, sample, now);
}

void hc_progress_finish(hc_progress *progress, const hc_progress_sample *sample) {
  if (!progress->stream) return;
  /* Too little happened since the last line to measure a rate from: keep the line's meaning, take the whole
   * run's. */
  progress->shown = progress->start;
  progress->shown_time = progress->start_time;
  show(progress, sample, hc_seconds());
  if (progress->terminal) fputc('\n', progress->stream);
  fflush(progress->stream);
  progress->stream = NULL;
}
