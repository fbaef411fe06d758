/* What the MPI tests share: one communicator, checks that all ranks fail together, random bits, the main
 * loop. */
#ifndef HC_MPI_TEST_H
#define HC_MPI_TEST_H

#include "comm/comm.h"

#include <check.h>
#include <stdlib.h>

static hc_comm comm;

/* splitmix64's mixer. */
static inline uint64_t mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

/* Fails on every rank if it fails on one, so that nobody waits for a rank that has left the test. */
static inline void expect_everywhere(bool good, const char *what, int line) {
  int64_t bad = !good;
  hc_comm_max_i64(&comm, &bad, 1);
  ck_assert_msg(!bad, "line %d: %s%s", line, what, good ? " (on another rank)" : "");
}
#define EXPECT(condition) expect_everywhere((condition), #condition, __LINE__)

/* Runs the tests after hc_comm_start(&comm, ...) and ends MPI; the exit code, the same on every rank. */
static inline int run_mpi_tests(const char *name, TCase *tests) {
  Suite *suite = suite_create(name);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_set_fork_status(runner, CK_NOFORK); /* MPI does not survive a fork */
  srunner_run_all(runner, comm.rank == 0 ? CK_NORMAL : CK_MINIMAL);
  int64_t failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  hc_comm_max_i64(&comm, &failed, 1);
  hc_comm_finish(&comm);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

#endif
