/* The decoder of zstd as the viewer needs it: whole frames from memory to memory, with one context that is always there. */

#include <stddef.h>

/* A static context allocates nothing. */
#define ZSTD_DEPS_MALLOC
#define ZSTD_malloc(size) NULL
#define ZSTD_calloc(count, size) NULL
#define ZSTD_free(address) ((void)(address))

#define ZSTD_STATIC_LINKING_ONLY
#include "zstd.c"

static ZSTD_DCtx context;

/* Decompress frames that follow each other; returns how many bytes came out, or a number below zero for an error. */
__attribute__((export_name("decompress"))) ptrdiff_t decompress(void* to, size_t capacity, const void* from, size_t size)
{
    ZSTD_initStaticDCtx(&context, sizeof context);
    return (ptrdiff_t)ZSTD_decompressDCtx(&context, to, capacity, from, size);
}
