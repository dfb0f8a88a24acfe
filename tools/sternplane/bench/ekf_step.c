/* The step of firmware_py/estimation/filter/bank.py in C, for `make bench` to compare with; no part of the product.
 *
 * Functions, their names and the order of every operation are those of the kernels in model/ and filter/, so that the
 * numbers are the same to the last bit; what is said there is not said again.
 */
#include "ekf_step_model.h"

enum { CHANNELS = 9, GROUP = 4, EQUATIONS = 6, BATCH = 3, EDDY_NORTH = MOVING + 2, PHI = 6, THETA = 7, PSI = 8 };

static const double PI = 3.141592653589793, COS_STEEP = 0.1;

/* --- covariance ------------------------------------------------------------------------------------------------- */

static void channel_covariance(const Bank *e, const double *restrict P, int64_t width)
{
    const int64_t stride = e->width;
    double *restrict channels = e->channels;
    for (int r = 0; r < CHANNELS; r++)
        for (int64_t j = 0; j < width; j++)
            channels[r * stride + j] = 0.0;
    for (int64_t g = 0; g < e->groups; g++) {
        double force[GROUP];
        const double *row[GROUP];
        for (int64_t i = 0, k = GROUP * g; i < GROUP; i++, k++) {
            force[i] = e->group_weight[k] * e->regressors[e->group_regressor[k]];
            row[i] = P + (e->first + e->group_parameter[k]) * stride;
        }
        double *channel = channels + e->group_equation[g] * stride;
        for (int64_t j = 0; j < width; j++)
            channel[j] += force[0] * row[0][j] + force[1] * row[1][j] + force[2] * row[2][j] + force[3] * row[3][j];
    }
    for (int64_t d = 0; d < e->water; d++) {
        const double *row = P + (MOVING + d) * stride;
        double *channel = channels + (EQUATIONS + (d < 2 ? d : d - 2)) * stride;
        for (int64_t j = 0; j < width; j++)
            channel[j] += row[j];
    }
}

static void motion_rows(const double *restrict P, Row *restrict Phi, Row *restrict response,
                        const double *restrict channels, int64_t stride, int64_t width, double *restrict FP)
{
    for (int i = 0; i < MOVING; i++) {
        const double *a = Phi[i], *r = response[i], *w = Phi[i] + WATER;
        double *out = FP + i * stride;
        for (int64_t j = 0; j < width; j++) {
            const double *p = P + j, *f = channels + j;
            const double moved = a[0] * p[0] + a[1] * p[stride] + a[2] * p[2 * stride] + a[3] * p[3 * stride] +
                                 a[4] * p[4 * stride] + a[5] * p[5 * stride] + a[6] * p[6 * stride] +
                                 a[7] * p[7 * stride] + a[8] * p[8 * stride];
            const double forced = r[0] * f[0] + r[1] * f[stride] + r[2] * f[2 * stride] + r[3] * f[3 * stride] +
                                  r[4] * f[4 * stride] + r[5] * f[5 * stride];
            out[j] = moved + forced + (w[0] * f[6 * stride] + w[1] * f[7 * stride] + w[2] * f[8 * stride]);
        }
    }
}

static void propagate(const Bank *e, double *restrict P, Row *restrict Phi, Row *restrict response)
{
    const int64_t n = e->n, width = e->width;
    double *restrict FP = e->FP;
    channel_covariance(e, P, width);
    motion_rows(P, Phi, response, e->channels, width, width, FP);
    for (int64_t j = 0; j < n; j++)
        for (int i = 0; i < MOVING; i++)
            P[j * width + i] = FP[i * width + j];
    for (int i = 0; i < MOVING; i++)
        for (int64_t j = MOVING; j < n; j++)
            P[i * width + j] = FP[i * width + j];
    channel_covariance(e, P, WATER + 3);
    motion_rows(P, Phi, response, e->channels, width, WATER + 3, FP);
    for (int i = 0; i < MOVING; i++)
        for (int j = 0; j <= i; j++)
            P[i * width + j] = P[j * width + i] = FP[i * width + j];
}

static void clear(const Bank *e)
{
    for (int64_t j = 0; j < BATCH * e->width; j++)
        e->PHt[j] = e->K[j] = 0.0;
}

static double update_state(const Bank *e, double *restrict x, const double *restrict P, int i, double innov, double R,
                           int slot, double *restrict S)
{
    const int64_t width = e->width, bias = e->bias_state[i];
    double *row = e->PHt + slot * width, *learned = e->K + slot * width, *row_0 = e->PHt, *row_1 = e->PHt + width;
    const double *P_i = P + i * width;
    double f_0 = row_0[i], f_1 = row_1[i];
    if (bias >= 0) {
        const double *P_bias = P + bias * width;
        f_0 += row_0[bias], f_1 += row_1[bias];
        for (int64_t j = 0; j < width; j++)
            row[j] = P_i[j] + P_bias[j] - f_0 * row_0[j] - f_1 * row_1[j];
        *S = row[i] + row[bias] + R;
    } else {
        for (int64_t j = 0; j < width; j++)
            row[j] = P_i[j] - f_0 * row_0[j] - f_1 * row_1[j];
        *S = row[i] + R;
    }
    const double nis = innov * innov / *S;
    if (!(nis <= e->gate * e->gate)) {
        for (int64_t j = 0; j < width; j++)
            row[j] = 0.0;
        return nis;
    }
    const double root = 1.0 / sqrt(*S), scaled = innov * root;
    for (int64_t j = 0; j < width; j++) {
        row[j] *= root;
        learned[j] = row[j] * e->learns[j];
        x[j] += learned[j] * scaled;
    }
    return nis;
}

static void update_covariance(const Bank *e, double *restrict P)
{
    const int64_t width = e->width;
    for (int64_t a = 0; a < e->n; a++) {
        const double f_0 = e->PHt[a], f_1 = e->PHt[width + a], f_2 = e->PHt[2 * width + a];
        const double *restrict rows = e->learns[a] != 0.0 ? e->PHt : e->K;
        double *row = P + a * width;
        for (int64_t j = 0; j < width; j++)
            row[j] -= f_0 * rows[j] + f_1 * rows[width + j] + f_2 * rows[2 * width + j];
    }
    clear(e);
}

/* --- bank ------------------------------------------------------------------------------------------------------- */

static double wrapped(double angle)
{
    if (-PI <= angle && angle < PI)
        return angle;
    const double around = fmod(angle + PI, 2.0 * PI);
    return (around < 0.0 ? around + 2.0 * PI : around) - PI;
}

static int weigh(const Bank *e)
{
    int best = 0;
    double total = 0.0;
    for (int b = 1; b < e->filters; b++)
        if (e->log_likelihood[b] > e->log_likelihood[best])
            best = b;
    for (int b = 0; b < e->filters; b++) {
        e->weights[b] = exp(e->log_likelihood[b] - e->log_likelihood[best]);
        total += e->weights[b];
    }
    for (int b = 0; b < e->filters; b++)
        e->weights[b] /= total;
    return best;
}

static double water_variance(const Bank *e, const double *P)
{
    const int64_t width = e->width;
    double variance = 0.0;
    for (int64_t i = MOVING; i < MOVING + e->water; i++)
        variance += P[i * width + i];
    if (e->water == EDDIES)
        variance += 2.0 * (P[MOVING * width + EDDY_NORTH] + P[(MOVING + 1) * width + EDDY_NORTH + 1]);
    return variance;
}

static bool step(const Bank *e, const double *inputs, double h, const double *z, const double *R, double *nis)
{
    const int64_t n = e->n, width = e->width;
    const double *low = e->lower, *high = e->upper;
    const int best = weigh(e);
    const double fade = exp(-h / e->likelihood_memory), decay = exp(-h / e->eddy_time);
    for (int i = 0; i < MOVING; i++)
        nis[i] = isnan(z[i]) ? NAN : 0.0;
    for (int b = 0; b < e->filters; b++) {
        double *x = e->x + b * width, *P = e->P + b * n * width, Phi[9][WIDTH], response[9][WIDTH];
        if (!predict(e, inputs, x, h, Phi, response))
            return false;
        const double eddy_noise = e->intensity[b] * sqrt(water_variance(e, P));
        propagate(e, P, Phi, response);
        for (int64_t i = 0; i < n; i++)
            P[i * width + i] += h * (e->Q[i] + eddy_noise * e->Q_eddy[i]);
        if (e->water == EDDIES)
            for (int i = EDDY_NORTH; i < EDDY_NORTH + 3; i++) {
                x[i] *= decay;
                for (int64_t j = 0; j < width; j++)
                    P[i * width + j] *= decay;
                for (int64_t j = 0; j < n; j++)
                    P[j * width + i] *= decay;
                P[i * width + i] += (1.0 - decay * decay) * e->intensity[b] * e->intensity[b];
            }
        double likelihood = 0.0;
        clear(e);
        for (int start = 0; start < MOVING; start += BATCH) {
            bool taken = false;
            double product_of_S = 1.0;
            for (int slot = 0; slot < BATCH; slot++) {
                const int i = start + slot;
                if (isnan(nis[i]))
                    continue;
                const bool turning = i == PHI || i == PSI;
                if (turning && fabs(cos(x[THETA])) < COS_STEEP)
                    continue;
                double innov = z[i] - x[i], S;
                if (e->bias_state[i] >= 0)
                    innov -= x[e->bias_state[i]];
                if (turning)
                    innov = wrapped(innov);
                double square = update_state(e, x, P, i, innov, R[i], slot, &S);
                taken = true, product_of_S *= S;
                if (!(square <= e->gate * e->gate)) {
                    square = e->gate * e->gate;
                    e->rejected[i] += b == best;
                }
                nis[i] += e->weights[b] * square;
                likelihood -= 0.5 * square;
            }
            if (taken) {
                likelihood -= 0.5 * log(product_of_S);
                update_covariance(e, P);
            }
        }
        e->log_likelihood[b] = fade * e->log_likelihood[b] + likelihood;
        x[PHI] = wrapped(x[PHI]), x[PSI] = wrapped(x[PSI]);
        double check = e->log_likelihood[b] * 0.0;
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

int64_t run(const Bank *e, int64_t steps, const double *inputs, double h, const double *z, const double *R,
            double *nis)
{
    for (int64_t k = 0; k < steps; k++)
        if (!step(e, inputs + 4 * k, h, z + 9 * k, R, nis + 9 * k))
            return k;
    return steps;
}
