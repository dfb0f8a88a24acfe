/* Loaded before a user-mode Linux older than 6.13, on a CPU with more registers than that knows.
 *
 * Such a kernel has room for 2696 bytes of extended registers; a CPU with AMX has more. The host gives a tracer as much
 * as it asks for, but takes the registers back only whole: "ptrace set fp regs failed, errno = 14". So hand them back
 * with zeros for the rest, which is AMX's: the header, in what the guest did save, says that it is not in use.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

typedef long (*ptrace_fn)(enum __ptrace_request, ...);

long ptrace(enum __ptrace_request request, ...)
{
    static ptrace_fn real;
    static char whole[1 << 16];
    static size_t size; /* of the host's registers, once known */

    if (!real)
        real = (ptrace_fn)dlsym(RTLD_NEXT, "ptrace");

    va_list arguments;
    va_start(arguments, request);
    int pid = va_arg(arguments, int);
    void *address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);

    struct iovec *given = data;
    if (request != PTRACE_SETREGSET || (long)address != NT_X86_XSTATE)
        return real(request, pid, address, data);
    if (!size) {
        struct iovec room = {whole, sizeof whole};
        if (real(PTRACE_GETREGSET, pid, address, &room) < 0)
            return -1;
        size = room.iov_len;
        memset(whole, 0, sizeof whole);
    }
    if (given->iov_len >= size)
        return real(request, pid, address, data);
    memcpy(whole, given->iov_base, given->iov_len);
    struct iovec padded = {whole, size};
    return real(request, pid, address, &padded);
}
