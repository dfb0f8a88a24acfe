/* The least that a fixed-rate loop can be: absolute deadlines, and how long after each it woke.
 *
 *     lateness PERIOD_NS COUNT      prints COUNT numbers, ns; that of tick 0, which waits for nothing, is not among them
 */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const long long NS_PER_S = 1000000000LL;

static long long now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

int main(int argc, char **argv)
{
    const long long period = argc == 3 ? atoll(argv[1]) : 0;
    const long count = argc == 3 ? atol(argv[2]) : 0;
    if (period <= 0 || count <= 0) {
        fprintf(stderr, "usage: lateness PERIOD_NS COUNT, both above 0\n");
        return 2;
    }
    long long *late = calloc((size_t)count, sizeof *late);
    if (!late) {
        perror("lateness");
        return 1;
    }
    const long long start = now();
    for (long k = 1; k <= count; k++) {
        const long long deadline = start + k * period;
        const struct timespec until = {deadline / NS_PER_S, deadline % NS_PER_S};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR)
            ;
        late[k - 1] = now() - deadline;
    }
    for (long k = 0; k < count; k++)
        printf("%lld\n", late[k]);
    free(late);
    return 0;
}
