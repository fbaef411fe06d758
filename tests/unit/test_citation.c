/* CITATION.cff is YAML and names the program, its version, its licence and the papers with their DOIs. */
#include "halocline/version.h"

#include <check.h>
#include <libfyaml.h>
#include <string.h>

static struct fy_node *root_of(struct fy_document **document) {
  *document = fy_document_build_from_file(NULL, HC_SOURCE_DIR "/CITATION.cff");
  ck_assert_msg(*document != NULL, "CITATION.cff is no YAML");
  return fy_document_root(*document);
}

static const char *text_at(struct fy_node *node, const char *path) {
  const char *text = fy_node_get_scalar0(fy_node_by_path(node, path, FY_NT, FYNWF_DONT_FOLLOW));
  return text ? text : "";
}

START_TEST(names_program) {
  struct fy_document *document;
  struct fy_node *root = root_of(&document);
  ck_assert_str_eq(text_at(root, "/cff-version"), "1.2.0");
  ck_assert_str_eq(text_at(root, "/title"), "Halocline");
  ck_assert_str_eq(text_at(root, "/version"), hc_version());
  ck_assert_str_eq(text_at(root, "/license"), "Apache-2.0");
  ck_assert_str_eq(text_at(root, "/authors/0/name"), "The Halocline authors");
  ck_assert_str_ne(text_at(root, "/message"), "");
  fy_document_destroy(document);
}
END_TEST

START_TEST(references_have_doi) {
  struct fy_document *document;
  struct fy_node *references = fy_node_by_path(root_of(&document), "/references", FY_NT, FYNWF_DONT_FOLLOW);
  ck_assert_int_ge(fy_node_sequence_item_count(references), 3);
  for (int k = 0; k < fy_node_sequence_item_count(references); k++) {
    struct fy_node *reference = fy_node_sequence_get_by_index(references, k);
    ck_assert_msg(strncmp(text_at(reference, "/doi"), "10.", 3) == 0, "reference %d has no DOI", k);
    ck_assert_str_ne(text_at(reference, "/title"), "");
    ck_assert_str_ne(text_at(reference, "/authors/0/family-names"), "");
  }
  fy_document_destroy(document);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("citation");
  TCase *tests = tcase_create("file");
  tcase_add_test(tests, names_program);
  tcase_add_test(tests, references_have_doi);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed != 0;
}
