/* Library for LD_PRELOAD in which allocations fail from the n-th one on. Environment variables: FAIL_CALL, the number n (0:
   none fails); FAIL_SIZE, bytes below which allocations are neither counted nor fail; FAIL_MARK, a file that gets the number
   of counted allocations when the program ends, or the size of the first allocation that failed. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The functions of glibc under their other names. */
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);

static long calls, failing_call = -1, smallest;
static int is_marked;

static void write_mark(const char *word, long number) {
    const char *path = getenv("FAIL_MARK");
    char line[64];
    int size = snprintf(line, sizeof line, "%s %ld\n", word, number);
    int file = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644) : -1;
    if (file >= 0 && write(file, line, size) > 0) close(file);
}

__attribute__((constructor)) static void begin(void) {
    const char *call = getenv("FAIL_CALL"), *size = getenv("FAIL_SIZE");
    smallest = size ? atol(size) : 0;
    failing_call = call ? atol(call) : 0;
}

__attribute__((destructor)) static void end(void) {
    if (!__atomic_load_n(&is_marked, __ATOMIC_SEQ_CST)) write_mark("counted", calls);
}

static int fails(size_t size) {
    if (failing_call < 0 || (long)size < smallest) return 0;
    long number = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
    if (failing_call == 0 || number < failing_call) return 0;
    if (!__atomic_exchange_n(&is_marked, 1, __ATOMIC_SEQ_CST)) write_mark("failed", (long)size);
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return fails(size) ? NULL : __libc_malloc(size); }

void *calloc(size_t count, size_t size) { return fails(count * size) ? NULL : __libc_calloc(count, size); }

void *realloc(void *old, size_t size) { return fails(size) ? NULL : __libc_realloc(old, size); }

void *aligned_alloc(size_t alignment, size_t size) { return fails(size) ? NULL : __libc_memalign(alignment, size); }

int posix_memalign(void **place, size_t alignment, size_t size) {
    if (fails(size)) return ENOMEM;
    *place = __libc_memalign(alignment, size);
    return *place ? 0 : ENOMEM;
}
