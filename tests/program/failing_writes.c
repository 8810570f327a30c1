/* Library for LD_PRELOAD that makes the n-th call fail that changes a folder: create, write, flush, truncate, rename,
   remove. Environment variables: FAIL_FOLDER, the prefix of paths; FAIL_CALL, the number n; FAIL_ERROR, the value of errno;
   FAIL_MODE, `once`, `rest` (all later calls fail too, except removals) or `short` (a write first writes its first half);
   FAIL_MARK, a file that gets a line for each call that failed. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILES 65536
/* Whether a descriptor is a file in the folder that is open for writing. */
static char is_watched[FILES];
static long calls, failing_call;
static const char *folder, *mark, *mode;
static int error_number;

__attribute__((constructor)) static void begin(void) {
    const char *call = getenv("FAIL_CALL"), *error = getenv("FAIL_ERROR");
    folder = getenv("FAIL_FOLDER");
    mark = getenv("FAIL_MARK");
    mode = getenv("FAIL_MODE");
    failing_call = call ? atol(call) : 0;
    error_number = error ? atoi(error) : EIO;
}

#define ORIGINAL(name) \
    static __typeof__(&name) original; \
    if (!original) original = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

static int is_inside(const char *path) { return folder && !strncmp(path, folder, strlen(folder)); }

static int is_watched_file(int file) { return file >= 0 && file < FILES && is_watched[file]; }

static void write_mark(const char *call, const char *path) {
    static int (*open_file)(const char *, int, ...);
    static ssize_t (*write_file)(int, const void *, size_t);
    open_file = (__typeof__(open_file))dlsym(RTLD_NEXT, "open64");
    write_file = (__typeof__(write_file))dlsym(RTLD_NEXT, "write");
    char line[4096];
    int file = open_file(mark, O_WRONLY | O_CREAT | O_APPEND, 0644);
    int size = snprintf(line, sizeof line, "%s %s\n", call, path);
    if (file >= 0 && write_file(file, line, size) > 0) close(file);
}

static int fails(const char *call, const char *path, int is_removal) {
    long number = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
    int is_later = mode && !strcmp(mode, "rest") && number > failing_call && !is_removal;
    if (number != failing_call && !is_later) return 0;
    write_mark(call, path);
    errno = error_number;
    return 1;
}

static int open_watched(int (*original)(const char *, int, ...), const char *path, int flags, mode_t permissions) {
    int is_written = is_inside(path) && (flags & (O_WRONLY | O_RDWR));
    if (is_written && fails("open", path, 0)) return -1;
    int file = original(path, flags, permissions);
    if (file >= 0 && file < FILES) is_watched[file] = is_written || (is_inside(path) && (flags & O_DIRECTORY));
    return file;
}

#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        ORIGINAL(name); \
        va_list rest; \
        va_start(rest, flags); \
        mode_t permissions = (flags & O_CREAT) ? va_arg(rest, mode_t) : 0; \
        va_end(rest); \
        return open_watched(original, path, flags, permissions); \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int file, const void *bytes, size_t size) {
    ORIGINAL(write);
    if (!is_watched_file(file)) return original(file, bytes, size);
    int is_short = mode && !strcmp(mode, "short") && size > 1;
    if (is_short && __atomic_load_n(&calls, __ATOMIC_SEQ_CST) + 1 == failing_call) {
        /* The write of the second half fails. */
        failing_call++;
        __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
        return original(file, bytes, size / 2);
    }
    return fails("write", folder, 0) ? -1 : original(file, bytes, size);
}

int fsync(int file) {
    ORIGINAL(fsync);
    return is_watched_file(file) && fails("flush", folder, 0) ? -1 : original(file);
}

int fdatasync(int file) {
    ORIGINAL(fdatasync);
    return is_watched_file(file) && fails("flush", folder, 0) ? -1 : original(file);
}

int ftruncate64(int file, off64_t size) {
    ORIGINAL(ftruncate64);
    return is_watched_file(file) && fails("truncate", folder, 0) ? -1 : original(file, size);
}

int rename(const char *from, const char *to) {
    ORIGINAL(rename);
    return is_inside(to) && fails("rename", to, 0) ? -1 : original(from, to);
}

int unlink(const char *path) {
    ORIGINAL(unlink);
    return is_inside(path) && fails("remove", path, 1) ? -1 : original(path);
}

int mkdir(const char *path, mode_t permissions) {
    ORIGINAL(mkdir);
    return is_inside(path) && fails("create", path, 0) ? -1 : original(path, permissions);
}
