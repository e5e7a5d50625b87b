/* Stamps the loops of one operator for every kernel and dimension.
 *
 * Before: OPERATOR (a name), `op_arguments` (a type), and always-inline functions with dim a literal
 *   op_load(a, dim, record, stride, first, &t)         W targets from their records into op_targets
 *   op_pair(a, dim, &t, source, &g, &s)                 one source of the first list into op_sums
 *   op_pair_second(a, dim, &t, source, &g, &s)          one source of the second list
 *   OP_STRIDE(dim), OP_STRIDE_SECOND(dim)               reals a source record
 *   op_store(a, dim, first, count, &t, &s)              sums out, `count` lanes from `first` on
 * and where its pairs are bare (see pair_units)
 *   #define OP_BARE 1
 *   op_metres(dim, units, &s)                           sums of bare pairs into those of metres
 * and where it prunes lists for others: #define OP_PRUNES 1
 * After: sphi_<OPERATOR>_loops_<variant>, indexed [kernel row][dim - 2].
 *
 * Every target's sum has one order whatever the number of threads.
 */
#ifndef OP_BARE
#define OP_BARE 0
#define op_metres(dim, units, s) (void)(units)
#endif
#ifndef OP_PRUNES
#define OP_PRUNES 0
#endif

/* What is done once a cluster is not stamped for every kernel, which would triple the time to compile. */
#define OP_ENDS(dim)                                                                               \
  static __attribute__((noinline)) void op_begin_##dim(const op_arguments *a, const real *record,  \
                                                       int stride, int32_t first, op_targets *t) { \
    op_load(a, dim, record, stride, first, t);                                                     \
  }                                                                                                \
  static __attribute__((noinline)) void op_end_##dim(                                              \
      const op_arguments *a, const pair_units *units, int32_t first, int32_t count,                \
      const op_targets *t, op_sums *s) {                                                           \
    op_metres(dim, units, s);                                                                      \
    op_store(a, dim, first, count, t, s);                                                          \
  }
OP_ENDS(2)
OP_ENDS(3)
#undef OP_ENDS

/* The first `near` of a cluster's sources are those that a loop visits. A pruning one visits all and
 * leaves in front, in their order, those within reach of a target; the far ones wait aside. */
enum { PRUNE_ROOM = 256 };

SPHI_INLINE void op_sources(const int kernel, const int dim, const int view, const bool second,
                            const bool prune, const op_arguments *a,
                            const pair_constants *constants, const vfixed *x, const op_targets *t,
                            const sphi_sweep *sweep, int32_t cluster, op_sums *s) {
  const sphi_list *list = sweep->source[second].list;
  sphi_list_entry *entry = &list->entry[cluster];
  uint32_t *restrict near = list->part[entry->part].source + entry->offset;
  const real *restrict sources = sweep->source[second].record;
  const size_t stride = (size_t)(second ? OP_STRIDE_SECOND(dim) : OP_STRIDE(dim));
  const int32_t count = prune ? entry->count : entry->near;
  uint32_t far[PRUNE_ROOM];
  int32_t kept = 0, away = 0;
  if (count == 0) return;
  /* One place ahead of the sums: processors do not see far enough to find that much to do at once. */
  uint32_t j = near[0];
  pair next;
  pair_place(dim, view, constants, x, sources + j * stride, &next);
  for (int32_t k = 0; k < count; k++) {
    const real *source = sources + j * stride;
    pair g = next;
    const uint32_t after = near[k + 1 < count ? k + 1 : k];
    pair_place(dim, view, constants, x, sources + after * stride, &next);
    pair_kernel(kernel, dim, view, constants, &g);
    if (prune) {
      const bool keep = v_bits_less(g.r2, v_set(constants->prune2)) != 0 || away == PRUNE_ROOM - 1;
      near[kept] = far[away] = j;
      kept += keep;
      away += !keep;
    }
    if (second)
      op_pair_second(a, dim, t, source, &g, s);
    else
      op_pair(a, dim, t, source, &g, s);
    j = after;
  }
  if (!prune) return;
  memcpy(near + kept, far, sizeof *far * (size_t)away);
  entry->near = kept;
}

SPHI_INLINE void op_loop(const int kernel, const int dim, const int view, const bool prune,
                         const sphi_sweep *sweep, const void *arguments, int32_t begin,
                         int32_t end) {
  const op_arguments *a = arguments;
  pair_constants constants;
  const pair_units units = pair_constants_set(&constants, view, sweep);
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
    op_sources(kernel, dim, view, false, prune, a, &constants, x, &t, sweep, cluster, &s);
    if (sweep->source[1].list)
      op_sources(kernel, dim, view, true, prune, a, &constants, x, &t, sweep, cluster, &s);
    op_sums sums = s;
    (dim == 2 ? op_end_2 : op_end_3)(a, &units, first, count, &seen, &sums);
  }
  v_leave();
}

#define OP_DIMENSION(id, stem, dim)                                                            \
  static void op_##stem##_##dim(const sphi_sweep *sweep, const void *arguments, int32_t begin, \
                                int32_t end) {                                                 \
    if (!OP_BARE)                                                                              \
      op_loop(id, dim, PAIR_METRES, OP_PRUNES, sweep, arguments, begin, end);                  \
    else if (sweep->frame->uniform)                                                            \
      op_loop(id, dim, PAIR_BARE, OP_PRUNES, sweep, arguments, begin, end);                    \
    else                                                                                       \
      op_loop(id, dim, PAIR_SCALED, OP_PRUNES, sweep, arguments, begin, end);                  \
  }
#define OP_STAMP(id, enumerator, stem, name, ratio, summary, source) \
  OP_DIMENSION(id, stem, 2)                                          \
  OP_DIMENSION(id, stem, 3)
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
