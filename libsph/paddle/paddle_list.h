/* The laws of motion: one row and one file for each.
 *
 * X(id, ENUMERATOR, stem, "name", "summary", "source"). The id is ABI: rows are added at the end, never
 * removed or renumbered, and include/sph/paddle.h has the same enumerators. A file <stem>.c holds the
 * law's create function and its table, a static const sphi_paddle_law. */
#ifndef SPHI_PADDLE_LIST_H
#define SPHI_PADDLE_LIST_H

#define SPHI_PADDLE_LIST(X)                                                                       \
  X(1, SOLITARY, solitary, "solitary", "solitary wave of any theory, implicit law",               \
    "Goring (1978)")                                                                              \
  X(2, SOLITARY_CLOSED, solitary_closed, "solitary-closed", "solitary wave, closed form",         \
    "Guizien and Barthelemy (2002)")                                                              \
  X(3, REGULAR, regular, "regular", "waves of one period, first or second order",                 \
    "Biesel (1951); Madsen (1971)")                                                               \
  X(4, IRREGULAR, irregular, "irregular", "random phases, JONSWAP or Pierson-Moskowitz spectrum", \
    "Hasselmann et al. (1973); Pierson and Moskowitz (1964)")                                     \
  X(5, FOCUSED, focused, "focused", "components whose crests meet", "Tromans et al. (1991)")      \
  X(6, SERIES, series, "series", "cubic spline through given displacements", "de Boor (1978)")    \
  X(7, FUNCTION, function, "function", "the caller's function, see sph_paddle_create_function",   \
    "the caller")

#endif
