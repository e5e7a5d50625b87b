/* Stamps the loops of one operator for every kernel and dimension.
 *
 * Before: OPERATOR (a name), `op_arguments` (a type), and always-inline functions with dim a literal
 *   op_load(a, dim, record, stride, first, &t)         W targets from their records into op_targets
 *   op_pair(a, dim, &t, source, &g, &s)                 one source of the first list into op_sums
 *   op_pair_second(a, dim, &t, source, &g, &s)          one source of the second list
 *   OP_STRIDE(dim), OP_STRIDE_SECOND(dim)               reals a source record
 *   op_store(a, dim, first, count, &t, &s)              sums out, `count` lanes from `first` on
 * After: sphi_<OPERATOR>_loops_<variant>, indexed [kernel row][dim - 2].
 *
 * Every target's sum has one order whatever the number of threads.
 */

/* What is done once a cluster is not stamped for every kernel, which would triple the time to compile. */
#define OP_ENDS(dim)                                                                               \
  static __attribute__((noinline)) void op_begin_##dim(const op_arguments *a, const real *record,  \
                                                       int stride, int32_t first, op_targets *t) { \
    op_load(a, dim, record, stride, first, t);                                                     \
  }                                                                                                \
  static __attribute__((noinline)) void op_end_##dim(const op_arguments *a, int32_t first,         \
                                                     int32_t count, const op_targets *t,           \
                                                     const op_sums *s) {                           \
    op_store(a, dim, first, count, t, s);                                                          \
  }
OP_ENDS(2)
OP_ENDS(3)
#undef OP_ENDS

SPHI_INLINE void op_loop(const int kernel, const int dim, const sphi_sweep *sweep,
                         const void *arguments, int32_t begin, int32_t end) {
  const op_arguments *a = arguments;
  pair_constants constants;
  pair_constants_set(&constants, sweep);
  for (int32_t c = begin; c < end; c++) {
    const int32_t cluster = sweep->subset ? sweep->subset[c] : c;
    const int32_t first = sweep->targets->first[cluster], count = sweep->targets->count[cluster];
    const real *record = (const real *)sweep->target + (int64_t)first * sweep->target_stride;
    vfixed x[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) x[d] = (vfixed)pair_lanes(record, sweep->target_stride, d);
    op_targets seen;
    (dim == 2 ? op_begin_2 : op_begin_3)(a, record, sweep->target_stride, first, &seen);
    /* Copies whose addresses stay here can live in registers. */
    const op_targets t = seen;
    op_sums s;
    memset(&s, 0, sizeof s);
    pair g;
    {
      const sphi_list *list = sweep->source[0].list;
      const sphi_list_entry entry = list->entry[cluster];
      const uint32_t *restrict near = list->part[entry.part].source + entry.offset;
      const real *restrict sources = sweep->source[0].record;
      for (int32_t k = 0; k < entry.count; k++) {
        const real *source = sources + (size_t)near[k] * (size_t)OP_STRIDE(dim);
        pair_geometry(kernel, dim, &constants, x, source, &g);
        op_pair(a, dim, &t, source, &g, &s);
      }
    }
    if (sweep->source[1].list) {
      const sphi_list *list = sweep->source[1].list;
      const sphi_list_entry entry = list->entry[cluster];
      const uint32_t *restrict near = list->part[entry.part].source + entry.offset;
      const real *restrict sources = sweep->source[1].record;
      for (int32_t k = 0; k < entry.count; k++) {
        const real *source = sources + (size_t)near[k] * (size_t)OP_STRIDE_SECOND(dim);
        pair_geometry(kernel, dim, &constants, x, source, &g);
        op_pair_second(a, dim, &t, source, &g, &s);
      }
    }
    const op_sums sums = s;
    (dim == 2 ? op_end_2 : op_end_3)(a, first, count, &seen, &sums);
  }
  v_leave();
}

#define OP_STAMP(id, enumerator, stem, name, ratio, summary, source)                       \
  static void op_##stem##_2(const sphi_sweep *sweep, const void *arguments, int32_t begin, \
                            int32_t end) {                                                 \
    op_loop(id, 2, sweep, arguments, begin, end);                                          \
  }                                                                                        \
  static void op_##stem##_3(const sphi_sweep *sweep, const void *arguments, int32_t begin, \
                            int32_t end) {                                                 \
    op_loop(id, 3, sweep, arguments, begin, end);                                          \
  }
SPHI_KERNEL_LIST(OP_STAMP)
#undef OP_STAMP

#define OP_LOOPS_(name) SPHI_NAME(sphi_##name##_loops)
#define OP_LOOPS(name) OP_LOOPS_(name)
extern const sphi_loop OP_LOOPS(OPERATOR)[SPHI_KERNEL_ROWS][2];
const sphi_loop OP_LOOPS(OPERATOR)[SPHI_KERNEL_ROWS][2] = {
#define OP_ROW(id, enumerator, stem, name, ratio, summary, source) \
  [(id)-1] = {op_##stem##_2, op_##stem##_3},
    SPHI_KERNEL_LIST(OP_ROW)
#undef OP_ROW
};
