/* Limits of memory by control groups, read from trees made for it. */
#include "base/cgroup.h"

#include <check.h>
#include <ftw.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static char root[64];

static int remove_one(const char *path, const struct stat *facts, int type, struct FTW *where) {
  (void)facts, (void)type, (void)where;
  return remove(path);
}

static void setup(void) {
  strcpy(root, "/tmp/halocline_cgroup_XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(root));
}

static void teardown(void) {
  nftw(root, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

/* Writes a file below the root, its folders too. */
static void put(const char *path, const char *text) {
  char whole[512];
  snprintf(whole, sizeof whole, "%s/%s", root, path);
  for (char *slash = strchr(whole + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    mkdir(whole, 0700);
    *slash = '/';
  }
  FILE *file = fopen(whole, "w");
  ck_assert_ptr_nonnull(file);
  fputs(text, file);
  fclose(file);
}

#define V2 "sys/fs/cgroup/"
#define V1 "sys/fs/cgroup/memory/"

START_TEST(without_groups_there_is_no_limit) {
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, SIZE_MAX);
  put("proc/self/cgroup", "0::/\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, SIZE_MAX);
  put(V2 "memory.max", "max\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, SIZE_MAX);
}
END_TEST

START_TEST(the_lowest_limit_on_the_way_to_the_root_counts) {
  put("proc/self/cgroup", "0::/slurm/job_7/step_0/task_1\n");
  put(V2 "slurm/memory.max", "9000000000\n");
  put(V2 "slurm/job_7/memory.max", "4000000000\n");
  put(V2 "slurm/job_7/step_0/memory.max", "max\n");
  put(V2 "slurm/job_7/step_0/task_1/memory.max", "max\n");
  put(V2 "slurm/job_8/memory.max", "1000\n");
  const hc_cgroup_limit limit = hc_cgroup_memory(root);
  ck_assert_uint_eq(limit.bytes, 4000000000);

  /* Another task of the job shares it; one with a limit of its own does not. */
  put("proc/self/cgroup", "0::/slurm/job_7/step_0/task_2\n");
  ck_assert_int_eq(hc_cgroup_memory(root).group, limit.group);
  put(V2 "slurm/job_7/step_0/task_2/memory.max", "3000000000\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, 3000000000);
  ck_assert_int_ne(hc_cgroup_memory(root).group, limit.group);
}
END_TEST

START_TEST(a_container_sees_its_group_as_the_root) {
  put("proc/self/cgroup", "0::/docker/0123456789\n");
  put(V2 "memory.max", "2147483648\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, 2147483648);
}
END_TEST

START_TEST(version_1_has_a_tree_for_memory) {
  put("proc/self/cgroup", "11:cpu,cpuacct:/fast\n5:hugetlb,memory:/job/step\n1:name=systemd:/memory\n0::/\n");
  put(V1 "memory.limit_in_bytes", "9223372036854771712\n");
  put(V1 "fast/memory.limit_in_bytes", "1000\n");
  put(V1 "job/memory.limit_in_bytes", "5000000000\n");
  put(V1 "job/step/memory.limit_in_bytes", "6000000000\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, 5000000000);
}
END_TEST

START_TEST(lines_of_other_forms_are_passed_over) {
  put("proc/self/cgroup", "\nnonsense\n0:\n3::\n0::/a\n");
  put(V2 "a/memory.max", "-\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, SIZE_MAX);
  put(V2 "a/memory.max", "7000\n");
  ck_assert_uint_eq(hc_cgroup_memory(root).bytes, 7000);
}
END_TEST

int main(void) {
  TCase *tests = tcase_create("cgroup");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_add_test(tests, without_groups_there_is_no_limit);
  tcase_add_test(tests, the_lowest_limit_on_the_way_to_the_root_counts);
  tcase_add_test(tests, a_container_sees_its_group_as_the_root);
  tcase_add_test(tests, version_1_has_a_tree_for_memory);
  tcase_add_test(tests, lines_of_other_forms_are_passed_over);
  Suite *suite = suite_create("cgroup");
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
