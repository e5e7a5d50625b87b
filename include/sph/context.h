/** @file
 * The context: errors and messages, memory, threads, instruction set. Every handle is created from
 * one, and two contexts share nothing.
 */
#ifndef SPH_CONTEXT_H
#define SPH_CONTEXT_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Memory functions that replace malloc and free.
 * allocate(bytes, user) returns memory aligned as malloc's, or NULL; release(memory, user) takes it
 * back. Both may be called from the thread that calls the library only.
 */
typedef struct sph_allocator {
  void *(*allocate)(size_t bytes, void *user);
  void (*release)(void *memory, void *user);
  void *user;
} sph_allocator;

/** How important a log message is. */
typedef enum sph_log_level {
  SPH_LOG_INFO = 0,
  SPH_LOG_WARNING = 1,
  SPH_LOG_ERROR = 2
} sph_log_level;

/** Receives one line without a newline. */
typedef void (*sph_log_function)(sph_log_level level, const char *message, void *user);

/** Instruction set of the pair loops. */
typedef enum sph_isa {
  SPH_ISA_AUTO = 0,     /**< the widest that this processor and this build have */
  SPH_ISA_BASELINE = 1, /**< what the compiler assumes of every processor of this kind */
  SPH_ISA_AVX2 = 2,     /**< x86-64 with AVX2 and FMA */
  SPH_ISA_AVX512 = 3    /**< x86-64 with AVX-512 F, DQ, VL and BW */
} sph_isa;

/** Arithmetic of the pair loops. Positions, velocities and densities always integrate in double. */
typedef enum sph_precision {
  SPH_PRECISION_SINGLE =
      0, /**< pair sums in float, on exact differences of positions: the default */
  SPH_PRECISION_DOUBLE = 1 /**< pair sums in double */
} sph_precision;

/** Create a context with the system's allocator, one thread and no log.
 *
 * Ownership  the caller destroys *out; handles created from it hold a counted reference
 * Parallel   thread-safe; a context is used by one thread at a time
 * Errors     SPH_E_ARGUMENT out is NULL; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_context_create(sph_context **out);

/** Create a context whose memory comes from the caller's allocator (copied; NULL: the system's).
 *
 * Ownership  as sph_context_create; allocator->user must live as long as the context's last handle
 * Parallel   as sph_context_create
 * Errors     SPH_E_ARGUMENT out or one of the two functions is NULL; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_context_create_with_allocator(const sph_allocator *allocator,
                                                                   sph_context **out);

/** Release the caller's reference and set *context to NULL. NULL is allowed.
 *
 * Ownership  the memory goes when the last handle made from it is destroyed
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_context_destroy(sph_context **context);

/** Send messages to a function (NULL: nowhere, the default).
 *
 * Ownership  user must live as long as the context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context is NULL
 * Since      0.1
 */
SPH_API sph_status sph_context_set_log(sph_context *context, sph_log_function log, void *user);

/** Threads of the loops over particles. Results do not depend on it.
 *
 * Units      threads >= 1; a build without OpenMP accepts only 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context NULL, threads < 1 or > 1024; SPH_E_UNAVAILABLE threads > 1 without OpenMP
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_context_set_threads(sph_context *context, int threads);

/** Threads in use; 0 if context is NULL.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_context_get_threads(const sph_context *context);

/** Processors this process may use.
 *
 * Parallel   thread-safe
 * Errors     none: at least 1
 * Since      0.1
 */
SPH_API int sph_processor_count(void);

/** Choose the instruction set of the pair loops for handles created afterwards.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context NULL or unknown value; SPH_E_UNAVAILABLE the processor or the
 *            build lacks it
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_context_set_isa(sph_context *context, sph_isa isa);

/** Instruction set in use, never SPH_ISA_AUTO unless context is NULL.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API sph_isa sph_context_get_isa(const sph_context *context);

/** Name of an instruction set: "baseline", "avx2", "avx512", "auto".
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_isa_name(sph_isa isa);

/** Choose the arithmetic of the pair loops of integrators created afterwards.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context NULL or unknown value
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_context_set_precision(sph_context *context,
                                                           sph_precision precision);

/** Code of the last error since the context was created; SPH_OK if there was none or context is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API sph_status sph_context_status(const sph_context *context);

/** What the last error was: object, constraint, value and way out, then the place in the source.
 *
 * Ownership  text in the context, valid until its next error; "" if there was none
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_context_message(const sph_context *context);

SPH_END_DECLS

#endif
