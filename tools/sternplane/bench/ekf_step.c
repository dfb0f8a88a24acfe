/* The step of firmware_py/estimation/filter/bank.py in C, for `make bench` to compare with; no part of the product.
 *
 * Functions, their names and the order of every operation are those of flow, transition, prediction, ekf and bank,
 * so that the numbers are the same to the last bit; what is said there is not said again.
 */
#include "ekf_step_model.h"

enum { GROWTH, LEARNS, LOW, HIGH, STIRS };
enum { CHANNELS = 9, FORCES = 6, BATCH = 3, EDDY = MOVING + 2, PHI = 6, THETA = 7, PSI = 8 };

static const double PI = 3.141592653589793, COS_STEEP = 0.1;

/* --- ekf -------------------------------------------------------------------------------------------------------- */

static void gather(const Bank *e, const double *restrict P, int64_t width, double *restrict F)
{
    const int64_t stride = e->width;
    for (int r = 0; r < CHANNELS; r++)
        for (int64_t j = 0; j < width; j++)
            F[r * stride + j] = 0.0;
    for (int64_t k = 0; k < e->picked; k++) {
        const double push = e->weight[k] * e->y[e->picks[k][1]];
        const double *row = P + (e->first + e->picks[k][0]) * stride;
        double *channel = F + e->picks[k][2] * stride;
        for (int64_t j = 0; j < width; j++)
            channel[j] += push * row[j];
    }
    for (int64_t d = 0; d < e->drift; d++) {
        const double *row = P + (MOVING + d) * stride;
        double *channel = F + (FORCES + (d < 2 ? d : d - 2)) * stride;
        for (int64_t j = 0; j < width; j++)
            channel[j] += row[j];
    }
}

static void carry(const double *restrict P, Row *restrict Phi, Row *restrict response, const double *restrict F,
                  int64_t stride, int64_t width, double *restrict T)
{
    for (int i = 0; i < MOVING; i++) {
        const double *a = Phi[i], *r = response[i], *w = Phi[i] + WATER;
        double *out = T + i * stride;
        for (int64_t j = 0; j < width; j++) {
            const double *p = P + j, *f = F + j;
            const double moved = a[0] * p[0] + a[1] * p[stride] + a[2] * p[2 * stride] + a[3] * p[3 * stride] +
                                 a[4] * p[4 * stride] + a[5] * p[5 * stride] + a[6] * p[6 * stride] +
                                 a[7] * p[7 * stride] + a[8] * p[8 * stride];
            const double pushed = r[0] * f[0] + r[1] * f[stride] + r[2] * f[2 * stride] + r[3] * f[3 * stride] +
                                  r[4] * f[4 * stride] + r[5] * f[5 * stride];
            out[j] = moved + pushed + (w[0] * f[6 * stride] + w[1] * f[7 * stride] + w[2] * f[8 * stride]);
        }
    }
}

static void spread(const Bank *e, double *restrict P, Row *restrict Phi, Row *restrict response)
{
    const int64_t n = e->n, width = e->width;
    double *restrict T = e->room, *restrict F = e->room + MOVING * width;
    gather(e, P, width, F);
    carry(P, Phi, response, F, width, width, T);
    for (int64_t j = 0; j < n; j++)
        for (int i = 0; i < MOVING; i++)
            P[j * width + i] = T[i * width + j];
    for (int i = 0; i < MOVING; i++)
        for (int64_t j = MOVING; j < n; j++)
            P[i * width + j] = T[i * width + j];
    gather(e, P, WATER + 3, F);
    carry(P, Phi, response, F, width, WATER + 3, T);
    for (int i = 0; i < MOVING; i++)
        for (int j = 0; j <= i; j++)
            P[i * width + j] = P[j * width + i] = T[i * width + j];
}

/* What the measurements of a batch take, behind T and F. */
static double *taken(const Bank *e)
{
    return e->room + (MOVING + CHANNELS) * e->width;
}

static double fuse(const Bank *e, double *restrict x, const double *restrict P, int i, double innovation,
                   double variance, int slot, double *restrict size)
{
    const int64_t width = e->width, bias = e->bias[i];
    const double *learns = e->rules + LEARNS * width;
    double *S = taken(e), *s = S + slot * width, *m = S + (BATCH + slot) * width, *s_0 = S, *s_1 = S + width;
    const double *row = P + i * width;
    double f_0 = s_0[i], f_1 = s_1[i];
    if (bias >= 0) {
        const double *more = P + bias * width;
        f_0 += s_0[bias], f_1 += s_1[bias];
        for (int64_t j = 0; j < width; j++)
            s[j] = row[j] + more[j] - f_0 * s_0[j] - f_1 * s_1[j];
        *size = s[i] + s[bias] + variance;
    } else {
        for (int64_t j = 0; j < width; j++)
            s[j] = row[j] - f_0 * s_0[j] - f_1 * s_1[j];
        *size = s[i] + variance;
    }
    const double nis = innovation * innovation / *size;
    if (!(nis <= e->gate * e->gate)) {
        for (int64_t j = 0; j < width; j++)
            s[j] = 0.0;
        return nis;
    }
    const double root = 1.0 / sqrt(*size), step = innovation * root;
    for (int64_t j = 0; j < width; j++) {
        s[j] *= root;
        m[j] = s[j] * learns[j];
        x[j] += m[j] * step;
    }
    return nis;
}

static void cut(const Bank *e, double *restrict P)
{
    const int64_t width = e->width;
    const double *learns = e->rules + LEARNS * width;
    double *restrict S = taken(e);
    for (int64_t a = 0; a < e->n; a++) {
        const double f_0 = S[a], f_1 = S[width + a], f_2 = S[2 * width + a];
        const double *s = learns[a] != 0.0 ? S : S + BATCH * width;
        double *row = P + a * width;
        for (int64_t j = 0; j < width; j++)
            row[j] -= f_0 * s[j] + f_1 * s[width + j] + f_2 * s[2 * width + j];
    }
    for (int64_t j = 0; j < 2 * BATCH * width; j++)
        S[j] = 0.0;
}

/* --- bank ------------------------------------------------------------------------------------------------------- */

static double wrapped(double angle)
{
    if (-PI <= angle && angle < PI)
        return angle;
    const double around = fmod(angle + PI, 2.0 * PI);
    return (around < 0.0 ? around + 2.0 * PI : around) - PI;
}

static int shares(const Bank *e)
{
    int likeliest = 0;
    double total = 0.0;
    for (int b = 1; b < e->members; b++)
        if (e->evidence[b] > e->evidence[likeliest])
            likeliest = b;
    for (int b = 0; b < e->members; b++) {
        e->weights[b] = exp(e->evidence[b] - e->evidence[likeliest]);
        total += e->weights[b];
    }
    for (int b = 0; b < e->members; b++)
        e->weights[b] /= total;
    return likeliest;
}

static double unknown(const Bank *e, const double *P)
{
    const int64_t width = e->width;
    double variance = 0.0;
    for (int64_t i = MOVING; i < MOVING + e->drift; i++)
        variance += P[i * width + i];
    if (e->drift == EDDIES)
        variance += 2.0 * (P[MOVING * width + EDDY] + P[(MOVING + 1) * width + EDDY + 1]);
    return variance;
}

static bool step(const Bank *e, const double *inputs, double h, const double *z, const double *variance, double *nis)
{
    const int64_t n = e->n, width = e->width;
    const double *growth = e->rules, *low = growth + LOW * width, *high = growth + HIGH * width;
    const double *stirs = growth + STIRS * width;
    double *S = taken(e);
    const int likeliest = shares(e);
    const double fade = exp(-h / e->memory), keep = exp(-h / e->eddy_time);
    for (int i = 0; i < MOVING; i++)
        nis[i] = isnan(z[i]) ? NAN : 0.0;
    for (int b = 0; b < e->members; b++) {
        double *x = e->x + b * width, *P = e->P + b * n * width, Phi[9][WIDTH], response[9][WIDTH];
        if (!predict(e, inputs, x, h, Phi, response))
            return false;
        const double stir = e->eddies[b] * sqrt(unknown(e, P));
        spread(e, P, Phi, response);
        for (int64_t i = 0; i < n; i++)
            P[i * width + i] += h * (growth[i] + stir * stirs[i]);
        if (e->drift == EDDIES)
            for (int i = EDDY; i < EDDY + 3; i++) {
                x[i] *= keep;
                for (int64_t j = 0; j < width; j++)
                    P[i * width + j] *= keep;
                for (int64_t j = 0; j < n; j++)
                    P[j * width + i] *= keep;
                P[i * width + i] += (1.0 - keep * keep) * e->eddies[b] * e->eddies[b];
            }
        double likelihood = 0.0;
        for (int64_t j = 0; j < 2 * BATCH * width; j++)
            S[j] = 0.0;
        for (int start = 0; start < MOVING; start += BATCH) {
            bool heard = false;
            double sizes = 1.0;
            for (int slot = 0; slot < BATCH; slot++) {
                const int i = start + slot;
                if (isnan(nis[i]))
                    continue;
                const bool turning = i == PHI || i == PSI;
                if (turning && fabs(cos(x[THETA])) < COS_STEEP)
                    continue;
                double innovation = z[i] - x[i], size;
                if (e->bias[i] >= 0)
                    innovation -= x[e->bias[i]];
                if (turning)
                    innovation = wrapped(innovation);
                double square = fuse(e, x, P, i, innovation, variance[i], slot, &size);
                heard = true, sizes *= size;
                if (!(square <= e->gate * e->gate)) {
                    square = e->gate * e->gate;
                    e->rejected[i] += b == likeliest;
                }
                nis[i] += e->weights[b] * square;
                likelihood -= 0.5 * square;
            }
            if (heard) {
                likelihood -= 0.5 * log(sizes);
                cut(e, P);
            }
        }
        e->evidence[b] = fade * e->evidence[b] + likelihood;
        x[PHI] = wrapped(x[PHI]), x[PSI] = wrapped(x[PSI]);
        double check = e->evidence[b] * 0.0;
        for (int64_t j = 0; j < n; j++) {
            const double least = low[j] > x[j] ? low[j] : x[j];
            x[j] = high[j] < least ? high[j] : least;
            check += (x[j] + P[j * width + j]) * 0.0;
        }
        if (check != 0.0)
            return false;
    }
    return true;
}

int64_t run(const Bank *e, int64_t steps, const double *inputs, double h, const double *z, const double *variance,
            double *nis)
{
    for (int64_t k = 0; k < steps; k++)
        if (!step(e, inputs + 4 * k, h, z + 9 * k, variance, nis + 9 * k))
            return k;
    return steps;
}
