/* Broken invariants: said with rank, file and line, then the process aborts (comm/ending.h ends the other
 * ranks). And what no caller can mend: said with the rank, then the program ends. */
#ifndef HC_CHECK_H
#define HC_CHECK_H

/* Names this process in the messages below; a label for people, never read by the simulation. */
void hc_check_set_rank(int rank);

_Noreturn void hc_check_failed(const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Aborts with a formatted message unless `condition` holds. The message states the constraint and the values.
 */
#define HC_CHECK(condition, ...)                                                                             \
  do {                                                                                                       \
    if (__builtin_expect(!(condition), 0)) hc_check_failed(__FILE__, __LINE__, __VA_ARGS__);                 \
  } while (0)

/* Ends the program where nobody can go on, because the machine lacks what it needs or the ranks are no longer
 * in the same place: with this exit code, no core dump. */
_Noreturn void hc_check_give_up(int exit_code, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* How the program ends there if other processes must end too; null: it has but this one. Some memory is kept
 * for it. */
void hc_check_set_leave(void (*leave)(int exit_code));

#endif
