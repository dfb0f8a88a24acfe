/* The observer model's step in C: flow, transition and prediction of firmware_py/estimation; see ekf_step.c. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "jacobians.h"

enum { MOVING = 9, WATER = 9, STATIONS = 5 };
enum { CURRENT = 2, EDDIES = 5 };

static const double U_S_MIN = 0.01, COS_MIN = 0.01;
static const double NODES[STATIONS] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                       0.9739065285171717};
static const double WEIGHTS[STATIONS] = {0.2955242247147529, 0.2692667193099964, 0.2190863625159820, 0.1494513491505806,
                                         0.0666713443086881};

typedef double Row[WIDTH];

/* A bank of filters: what bank.step takes, and the sizes of its arrays; bench/ekf.py has the same structure. */
typedef struct {
    int64_t n, width, filters, terms, groups, water, first, added_mass;
    double eddy_time, likelihood_memory, gate;
    double *constants, (*inverse_mass)[6];
    const int64_t *parameter, *regressor, *equation, *constant;
    const double *weight;
    const int64_t *group_parameter, *group_regressor;
    const double *group_weight;
    const int64_t *group_equation;
    double *regressors, *FP, *channels, *PHt, *K;
    const double *Q, *Q_eddy, *learns, *lower, *upper;
    const int64_t *bias_state;
    const double *intensity;
    double *x, *P, *log_likelihood, *weights;
    int64_t *rejected;
} Bank;

/* --- flow ------------------------------------------------------------------------------------------------------- */

static void turn(double phi, double theta, double psi, double *restrict t)
{
    const double c_theta = cos(theta);
    t[0] = sin(phi), t[1] = cos(phi), t[2] = sin(theta), t[3] = c_theta, t[4] = sin(psi), t[5] = cos(psi);
    t[6] = 1.0 / copysign(fabs(c_theta) >= COS_MIN ? fabs(c_theta) : COS_MIN, c_theta);
}

static double behind_disc(const double *c, double u, double u_n)
{
    const double square = u * fabs(u) + c[K_RACE] * u_n * fabs(u_n);
    return copysign(sqrt(fabs(square)), square);
}

static void race(const double *c, double u, double n, double *restrict out)
{
    const double u_n = c[ADVANCE] * n;
    out[0] = fabs(u), out[1] = (behind_disc(c, u, u_n) - u) / c[KNEE] - u, out[2] = u_n * fabs(u_n);
}

static void race_slopes(const double *c, double u, double n, double *restrict s_u, double *restrict e_u)
{
    const double behind = fabs(behind_disc(c, u, c[ADVANCE] * n)), u_s = behind >= U_S_MIN ? behind : U_S_MIN;
    *s_u = copysign(1.0, u), *e_u = (fabs(u) / u_s - 1.0) / c[KNEE] - 1.0;
}

static void cross_flow(const double *restrict c, double v, double w, double q, double r, double *restrict out)
{
    const double half = 0.5 * c[LENGTH];
    double Y = 0.0, Z = 0.0, M = 0.0, N = 0.0;
    for (int i = 0; i < STATIONS; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double x = side * NODES[i] * half, across = v + x * r, down = w - x * q;
            const double speed = sqrt(across * across + down * down);
            if (speed > 0.0) {
                double d[2];
                strip(c, across, down, speed, d);
                Y += WEIGHTS[i] * d[0], Z += WEIGHTS[i] * d[1];
                M -= WEIGHTS[i] * x * d[1], N += WEIGHTS[i] * x * d[0];
            }
        }
    const double size = c[SCALE] * half;
    out[0] = size * Y, out[1] = size * Z, out[2] = size * M, out[3] = size * N;
}

static void cross_flow_slopes(const double *restrict c, double v, double w, double q, double r, Row *restrict D,
                              double *restrict y)
{
    const double half = 0.5 * c[LENGTH], size = c[SCALE] * half;
    double a[8] = {0}, s[4] = {0}, sx[4] = {0}, sxx[4] = {0};
    for (int i = 0; i < STATIONS; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double x = side * NODES[i] * half, across = v + x * r, down = w - x * q;
            const double speed = sqrt(across * across + down * down);
            if (speed > 0.0) {
                const double k = size * WEIGHTS[i], kx = k * x, kxx = k * x * x;
                double d[8];
                strip_slopes(c, across, down, speed, d);
                a[0] += k * d[0], a[1] += k * d[1], a[2] -= kx * d[1], a[3] += kx * d[0];
                a[4] += k * d[2], a[5] += k * d[3], a[6] -= kx * d[3], a[7] += kx * d[2];
                for (int j = 0; j < 4; j++)
                    s[j] += k * d[4 + j], sx[j] += kx * d[4 + j], sxx[j] += kxx * d[4 + j];
            }
        }
    for (int j = 0; j < 8; j++)
        y[j] = a[j];
    enum { Y_v, Y_w, Z_v, Z_w };
    D[1][1] += s[Y_v], D[1][2] += s[Y_w], D[1][4] -= sx[Y_w], D[1][5] += sx[Y_v];
    D[2][1] += s[Z_v], D[2][2] += s[Z_w], D[2][4] -= sx[Z_w], D[2][5] += sx[Z_v];
    D[4][1] -= sx[Z_v], D[4][2] -= sx[Z_w], D[4][4] += sxx[Z_w], D[4][5] -= sxx[Z_v];
    D[5][1] += sx[Y_v], D[5][2] += sx[Y_w], D[5][4] -= sxx[Y_w], D[5][5] += sxx[Y_v];
}

/* --- transition ------------------------------------------------------------------------------------------------- */

static bool invert(double (*restrict M)[6], double (*restrict inverse)[6])
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            inverse[i][j] = i == j;
    for (int k = 0; k < 6; k++) {
        int best = k;
        for (int i = k + 1; i < 6; i++)
            if (fabs(M[i][k]) > fabs(M[best][k]))
                best = i;
        if (!(fabs(M[best][k]) > 0.0 && fabs(M[best][k]) < INFINITY))
            return false;
        for (int j = 0; j < 6; j++) {
            const double m = M[k][j], n = inverse[k][j];
            M[k][j] = M[best][j], M[best][j] = m;
            inverse[k][j] = inverse[best][j], inverse[best][j] = n;
        }
        const double scale = 1.0 / M[k][k];
        for (int j = 0; j < 6; j++)
            M[k][j] *= scale, inverse[k][j] *= scale;
        for (int i = 0; i < 6; i++) {
            const double factor = M[i][k];
            if (i != k && factor != 0.0)
                for (int j = 0; j < 6; j++)
                    M[i][j] -= factor * M[k][j], inverse[i][j] -= factor * inverse[k][j];
        }
    }
    return true;
}

static void linearise(const double *restrict c, double (*restrict inverse)[6], const double *restrict inputs,
                      const double *restrict x, const double *restrict x_dot, const double *restrict water,
                      Row *restrict A, Row *restrict D, Row *restrict B, double *restrict y)
{
    const double p = x[3], q = x[4], r = x[5], ds = inputs[0], dr = inputs[1], db = inputs[2];
    double t[7], k[9], s[3], s_u, e_u;
    turn(x[6], x[7], x[8], t);
    kinematics(p, q, r, t[0], t[1], t[2], t[3], t[4], t[5], t[6], water[0], water[1], water[2], k);
    const double u = x[0] - k[0], v = x[1] - k[1], w = x[2] - k[2];
    race(c, u, inputs[3], s);
    race_slopes(c, u, inputs[3], &s_u, &e_u);
    regressors(c, u, v, w, p, q, r, x_dot[0] - k[3], x_dot[1] - k[4], x_dot[2] - k[5], x_dot[3], x_dot[4], x_dot[5], ds, dr,
            db, s[0], s[1], s[2], y);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < WIDTH; j++)
            D[i][j] = 0.0;
    slopes(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], ds, dr, db, s[0], s[1], s_u, e_u, D);
    cross_flow_slopes(c, v, w, q, r, D, y + DRAG);
    buoyancy(c, t[0], t[1], t[2], t[3], y + BUOYANCY);
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < WIDTH; j++)
            A[i][j] = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < WIDTH; j++)
            B[i][j] = 0.0;
    kinematic_slopes(p, q, r, t[0], t[1], t[2], t[3], t[4], t[5], t[6], water[0], water[1], water[2], A, B);
    for (int i = 0; i < 6; i++)
    {
        const double d_0 = D[i][0], d_1 = D[i][1], d_2 = D[i][2];
        for (int j = 0; j < WIDTH; j++)
            D[i][j] -= d_0 * B[0][j] + d_1 * B[1][j] + d_2 * B[2][j];
    }
    for (int i = 0; i < 6; i++) {
        const double *m = inverse[i];
        for (int j = 0; j < WIDTH; j++)
            A[i][j] += m[0] * D[0][j] + m[1] * D[1][j] + m[2] * D[2][j] + m[3] * D[3][j] + m[4] * D[4][j] +
                       m[5] * D[5][j];
    }
}

static void product(Row *X, double h, Row *Y, Row *restrict Z)
{
    for (int i = 0; i < 9; i++) {
        double x[9];
        for (int k = 0; k < 9; k++)
            x[k] = h * X[i][k];
        for (int j = 0; j < WIDTH; j++)
            Z[i][j] = x[0] * Y[0][j] + x[1] * Y[1][j] + x[2] * Y[2][j] + x[3] * Y[3][j] + x[4] * Y[4][j] +
                      x[5] * Y[5][j] + x[6] * Y[6][j] + x[7] * Y[7][j] + x[8] * Y[8][j];
    }
}

static void transition(double (*restrict inverse)[6], double h, Row *restrict A, Row *restrict G, Row *restrict Phi,
                       Row *restrict response)
{
    product(A, h * h / 6.0, A, Phi);
    for (int i = 0; i < 9; i++) {
        for (int j = 0; j < WIDTH; j++)
            G[i][j] = h / 2.0 * A[i][j] + Phi[i][j];
        G[i][i] += 1.0;
    }
    product(G, h, A, Phi);
    for (int i = 0; i < 9; i++) {
        Phi[i][i] += 1.0;
        double g[6];
        for (int k = 0; k < 6; k++)
            g[k] = h * G[i][k];
        for (int j = 0; j < 6; j++)
            response[i][j] = g[0] * inverse[0][j] + g[1] * inverse[1][j] + g[2] * inverse[2][j] +
                             g[3] * inverse[3][j] + g[4] * inverse[4][j] + g[5] * inverse[5][j];
    }
}

/* --- prediction ------------------------------------------------------------------------------------------------- */

static void rates(const double *restrict c, double (*restrict inverse)[6], const double *restrict inputs,
                  const double *restrict x, const double *restrict water, double *restrict x_dot)
{
    const double p = x[3], q = x[4], r = x[5];
    double t[7], k[9], s[3], tau[6], d[4];
    turn(x[6], x[7], x[8], t);
    kinematics(p, q, r, t[0], t[1], t[2], t[3], t[4], t[5], t[6], water[0], water[1], water[2], k);
    const double u = x[0] - k[0], v = x[1] - k[1], w = x[2] - k[2];
    race(c, u, inputs[3], s);
    forces(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], inputs[0], inputs[1], inputs[2], s[0], s[1], s[2], tau);
    cross_flow(c, v, w, q, r, d);
    tau[1] += d[0], tau[2] += d[1], tau[4] += d[2], tau[5] += d[3];
    for (int i = 0; i < 6; i++) {
        const double *m = inverse[i];
        x_dot[i] = m[0] * tau[0] + m[1] * tau[1] + m[2] * tau[2] + m[3] * tau[3] + m[4] * tau[4] + m[5] * tau[5];
    }
    for (int i = 0; i < 3; i++)
        x_dot[i] += k[3 + i], x_dot[6 + i] = k[6 + i];
}

static void along(const double *x, double h, const double *k, double *out)
{
    for (int i = 0; i < 9; i++)
        out[i] = x[i] + h * k[i];
}

static bool predict(const Bank *e, const double *restrict inputs, double *restrict x, double h, Row *restrict Phi,
                    Row *restrict response)
{
    double M[6][6], k_1[9], k_2[9], k_3[9], k_4[9], x_2[9], x_3[9], x_4[9], water[3] = {0.0, 0.0, 0.0};
    for (int64_t k = 0; k < e->terms; k++)
        e->constants[e->constant[k]] = e->weight[k] * x[e->first + e->parameter[k]];
    if (e->added_mass) {
        mass(e->constants, M);
        if (!invert(M, e->inverse_mass))
            return false;
    }
    if (e->water == EDDIES)
        water[0] = x[9] + x[11], water[1] = x[10] + x[12], water[2] = x[13];
    else if (e->water == CURRENT)
        water[0] = x[9], water[1] = x[10];
    rates(e->constants, e->inverse_mass, inputs, x, water, k_1);
    along(x, 0.5 * h, k_1, x_2);
    rates(e->constants, e->inverse_mass, inputs, x_2, water, k_2);
    along(x, 0.5 * h, k_2, x_3);
    rates(e->constants, e->inverse_mass, inputs, x_3, water, k_3);
    along(x, h, k_3, x_4);
    rates(e->constants, e->inverse_mass, inputs, x_4, water, k_4);
    double check = 0.0, end[9];
    along(x, h / 6.0, k_1, end);
    along(end, h / 3.0, k_2, end);
    along(end, h / 3.0, k_3, end);
    along(end, h / 6.0, k_4, end);
    for (int i = 0; i < 9; i++)
        check += end[i] * 0.0;
    if (check != 0.0)
        return false;
    double A[9][WIDTH], G[9][WIDTH], D[6][WIDTH], B[3][WIDTH];
    linearise(e->constants, e->inverse_mass, inputs, x_3, k_3, water, A, D, B, e->regressors);
    transition(e->inverse_mass, h, A, G, Phi, response);
    for (int i = 0; i < 9; i++)
        x[i] = end[i];
    return true;
}
