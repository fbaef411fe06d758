/* Instruction sets the pair loops are compiled for. One choice per run: all ranks agree on the least of
 * theirs. avx2 and avx512 give the same bits; portable has no fused multiply-add and gives others. */
#ifndef HC_ISA_H
#define HC_ISA_H

typedef enum hc_isa { HC_ISA_PORTABLE, HC_ISA_AVX2, HC_ISA_AVX512, HC_ISA_COUNT } hc_isa;

/* The best this processor can run; the environment variable HALOCLINE_ISA (portable, avx2, avx512) may lower
 * it. */
hc_isa hc_isa_best(void);
const char *hc_isa_name(hc_isa isa);

#endif
