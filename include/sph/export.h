/** @file
 * Linkage macros shared by all public headers.
 */
#ifndef SPH_EXPORT_H
#define SPH_EXPORT_H

#ifdef __cplusplus
#define SPH_BEGIN_DECLS extern "C" {
#define SPH_END_DECLS }
#else
#define SPH_BEGIN_DECLS
#define SPH_END_DECLS
#endif

#if defined(__GNUC__) || defined(__clang__)
#define SPH_API __attribute__((visibility("default")))
#define SPH_NODISCARD __attribute__((warn_unused_result))
#else
#define SPH_API
#define SPH_NODISCARD
#endif

#endif
