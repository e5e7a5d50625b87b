/* Picks the variant, and runs loops with threads. */
#include "sweep/variant.h"

#if defined(__x86_64__) && !defined(SPHI_NO_X86_VARIANTS)
#define VARIANT_LIST(X)         \
  X(base_f32, SPH_ISA_BASELINE) \
  X(base_f64, SPH_ISA_BASELINE) \
  X(avx2_f32, SPH_ISA_AVX2)     \
  X(avx2_f64, SPH_ISA_AVX2)     \
  X(avx512_f32, SPH_ISA_AVX512) \
  X(avx512_f64, SPH_ISA_AVX512)
#else
#define VARIANT_LIST(X)         \
  X(base_f32, SPH_ISA_BASELINE) \
  X(base_f64, SPH_ISA_BASELINE)
#endif

#define VARIANT_DECLARE(name, isa) extern const sphi_variant sphi_variant_##name;
VARIANT_LIST(VARIANT_DECLARE)
#undef VARIANT_DECLARE
extern const sphi_variant sphi_variant_scalar;

const sphi_variant *sphi_variant_find(sph_isa isa, sph_precision precision) {
  static const struct {
    sph_isa isa;
    const sphi_variant *variant;
  } rows[] = {
#define VARIANT_ROW(name, isa) {isa, &sphi_variant_##name},
      VARIANT_LIST(VARIANT_ROW)
#undef VARIANT_ROW
  };
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
    if (rows[k].isa == isa && rows[k].variant->is_double == (precision == SPH_PRECISION_DOUBLE))
      return rows[k].variant;
  return NULL;
}

const sphi_variant *sphi_variant_reference(void) { return &sphi_variant_scalar; }

enum { BLOCK = 16 }; /* clusters a thread takes at a time */

void sphi_sweep_run(sph_context *context, const sphi_variant *variant, int operator_index,
                    const sphi_sweep *sweep, const void *arguments) {
  (void)context; /* without OpenMP nobody asks it for its threads */
  const sphi_loop loop =
      variant->loops[operator_index][sweep->kernel->type - 1][sweep->frame->dim - 2];
  const int32_t n = sweep->subset ? sweep->subset_count : sweep->targets->n;
  const int32_t blocks = (n + BLOCK - 1) / BLOCK;
#pragma omp parallel for num_threads(context->threads) schedule(dynamic) if (blocks > 1)
  for (int32_t block = 0; block < blocks; block++) {
    const int32_t begin = block * BLOCK, end = begin + BLOCK < n ? begin + BLOCK : n;
    loop(sweep, arguments, begin, end);
  }
}

int64_t sphi_sweep_pairs(const sphi_sweep *sweep) {
  int64_t sum = 0;
  for (int s = 0; s < 2; s++) {
    const sphi_list *list = sweep->source[s].list;
    for (int32_t c = 0; list && c < sweep->targets->n; c++)
      sum += (int64_t)list->entry[c].near * sweep->targets->count[c];
  }
  return sum;
}

void sphi_pack_run(sph_context *context, const sphi_variant *variant, const sphi_pack *pack) {
  (void)context; /* without OpenMP nobody asks it for its threads */
  enum { POINTS = 1024 };
  const int32_t blocks = (pack->n + POINTS - 1) / POINTS;
#pragma omp parallel for num_threads(context->threads) schedule(static) if (blocks > 1)
  for (int32_t block = 0; block < blocks; block++) {
    const int32_t begin = block * POINTS, end = begin + POINTS < pack->n ? begin + POINTS : pack->n;
    variant->pack(pack, begin, end);
  }
}

void sphi_list_free(sph_context *context, sphi_list *list) {
  sphi_free(context, list->entry);
  for (int32_t p = 0; p < list->parts; p++) sphi_free(context, list->part[p].source);
  sphi_free(context, list->part);
  memset(list, 0, sizeof *list);
}

static bool reserve_parts(sph_context *context, sphi_list *list, int32_t parts) {
  if (parts <= list->parts) return true;
  sphi_list_part *part = SPHI_NEW(context, parts, sphi_list_part);
  if (!part) return false;
  if (list->parts) memcpy(part, list->part, (size_t)list->parts * sizeof *part);
  sphi_free(context, list->part);
  list->part = part;
  list->parts = parts;
  return true;
}

sph_status sphi_list_build(sph_context *context, sphi_list *list, const sphi_frame *frame,
                           const sphi_clusters *targets, const sphi_columns *sources,
                           double radius) {
  /* Starting threads takes as long as listing some hundred clusters. With more parts than threads those
   * that start late have less to do; parts take blocks in turn, so that all are about as long. */
  enum { PARALLEL_FROM = 512, PARTS = 4, BLOCK_OF_ROWS = 64 };
  const int32_t threads = targets->n < PARALLEL_FROM ? 1 : context->threads;
  const int32_t parts = threads > 1 ? PARTS * threads : 1;
  const int64_t block = parts > 1 ? BLOCK_OF_ROWS : targets->n;
  const sphi_list_function rows = sphi_variant_find(context->isa, SPH_PRECISION_SINGLE)->list;
  /* Head room everywhere: numbers vary a little from build to build. */
  const int64_t entries =
      targets->n <= list->capacity ? targets->n : (int64_t)targets->n + targets->n / 8 + 16;
  list->clusters = targets->n;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&list->entry, &list->capacity, entries, sizeof *list->entry) &&
          reserve_parts(context, list, parts),
      SPH_E_MEMORY, "no memory for neighbour lists of %d clusters", targets->n);
  for (bool fits = false; !fits;) {
#pragma omp parallel for num_threads(threads) schedule(dynamic) if (threads > 1)
    for (int32_t p = 0; p < parts; p++) {
      list->part[p].used = 0;
      for (int64_t begin = p * block; begin < targets->n; begin += parts * block) {
        const int64_t end = begin + block;
        rows(list, p, frame, targets, sources, radius, (int32_t)begin,
             (int32_t)(end < targets->n ? end : targets->n));
        if (list->part[p].used < 0) break;
      }
    }
    fits = true;
    list->total = 0;
    for (int32_t p = 0; p < parts; p++) {
      sphi_list_part *part = &list->part[p];
      SPH_CHECK(context, part->used >= 0, SPH_E_INTERNAL,
                "columns %g m wide are too narrow for neighbour lists of radius %g m",
                sources->width[0], radius);
      list->total += part->used;
      /* A part that ran over has only been counted: make room and build once more. */
      if (part->used + SPHI_PAD <= part->capacity || part->used == 0) continue;
      fits = false;
      SPH_CHECK(context,
                sphi_reserve(context, (void **)&part->source, &part->capacity,
                             part->used + part->used / 4 + 1024 / parts, sizeof *part->source),
                SPH_E_MEMORY, "no memory for neighbour lists of %lld entries",
                (long long)list->total);
    }
  }
  return SPH_OK;
}
