// What dnanalyze.model.kernels does to a row of pixels, to one pixel; operation by operation the
// same, so that IEEE 754 gives the same bits as long as the compiler fuses none (--fmad=false).
// The coefficients L, Z, A, B, C, INVERTED_BELOW, LN2, ... and the table INVERSE are those of that module.

typedef unsigned long long u64;
typedef unsigned int u32;
typedef unsigned short u16;
typedef unsigned char u8;

// The random word of a pixel: SplitMix64 finaliser, upper half.
__device__ inline u32 word(u64 key, u32 index) {
    u64 z = key + (u64(index) + 1) * GOLDEN;
    z = (z ^ (z >> 30)) * MIX1;
    z = (z ^ (z >> 27)) * MIX2;
    return u32((z ^ (z >> 31)) >> 32);
}

__device__ inline float uniform(u32 word) {
    const float u = (float(word) + 0.5f) * TINY;
    return u < BELOW_ONE ? u : BELOW_ONE;
}

__device__ inline float logarithm(float v) {
    const int i = __float_as_int(v) - SQRT_HALF_BITS;
    const float m = __int_as_float((i & MANTISSA) + SQRT_HALF_BITS) - 1.0f;
    float p = L7 * m + L6;
    p = p * m + L5;
    p = p * m + L4;
    p = p * m + L3;
    p = p * m + L2;
    p = p * m + L1;
    p = p * m + L0;
    return float(i >> 23) * LN2 + p * m;
}

__device__ inline float normal(u32 word) {
    const int b = int(word ^ 0x80000000u);
    const float x = (float(b) + 0.5f) * UNIT;
    const float q = (float(0x7fffffff - (b ^ (b >> 31))) + 0.5f) * UNIT;
    const float w = -logarithm(q * (2.0f - q));
    const float t = A - B / (w + C);
    float p = Z12 * t + Z11;
    p = p * t + Z10;
    p = p * t + Z9;
    p = p * t + Z8;
    p = p * t + Z7;
    p = p * t + Z6;
    p = p * t + Z5;
    p = p * t + Z4;
    p = p * t + Z3;
    p = p * t + Z2;
    p = p * t + Z1;
    p = p * t + Z0;
    return x * p;
}

__device__ inline float exponential(float x) {
    x = x > -87.0f ? x : -87.0f;
    x = x < 88.0f ? x : 88.0f;
    const float n = rintf(x * LOG2E);
    const float r = (x - n * LN2_HIGH) - n * LN2_LOW;
    float p = float(1.0 / 5040) * r + float(1.0 / 720);
    p = p * r + float(1.0 / 120);
    p = p * r + float(1.0 / 24);
    p = p * r + float(1.0 / 6);
    p = p * r + 0.5f;
    p = p * r + 1.0f;
    p = p * r + 1.0f;
    return p * __int_as_float((int(n) + 127) << 23);
}

// Poisson counts of a mean from INVERTED_BELOW on: Cornish-Fisher.
__device__ inline float many(u32 word, float lam) {
    const float z = normal(word);
    const float s2 = lam - float(1.0 / 12);
    const float s = sqrtf(s2);
    const float g1 = lam / (s2 * s);
    const float g2 = (lam + float(1.0 / 120)) / (s2 * s2);
    const float z2 = z * z;
    float w = z + g1 * (z2 - 1.0f) * float(1.0 / 6);
    w += z * (g2 * (z2 - 3.0f) * float(1.0 / 24)
              - g1 * g1 * (2.0f * z2 - 5.0f) * float(1.0 / 36));
    w += g1 / s2 * (z2 * (z2 - 6.0f) + 3.0f) * float(1.0 / 120);
    w -= g1 * g2 * (z2 * (z2 - 5.0f) + 2.0f) * float(1.0 / 24);
    w += g1 * g1 * g1 * (z2 * (12.0f * z2 - 53.0f) + 17.0f) * float(1.0 / 324);
    const float n = rintf(lam + s * w);
    return n > 0.0f ? n : 0.0f;
}

// Poisson counts of a mean below INVERTED_BELOW: inversion.
__device__ inline float few(u32 word, float mean) {
    const double lam = mean;
    const double x = lam * (-1.0 / 16);
    double e = 1.0 + x * (1.0 / 12);
    e = 1.0 + x * (1.0 / 11) * e;
    e = 1.0 + x * (1.0 / 10) * e;
    e = 1.0 + x * (1.0 / 9) * e;
    e = 1.0 + x * (1.0 / 8) * e;
    e = 1.0 + x * (1.0 / 7) * e;
    e = 1.0 + x * (1.0 / 6) * e;
    e = 1.0 + x * (1.0 / 5) * e;
    e = 1.0 + x * (1.0 / 4) * e;
    e = 1.0 + x * (1.0 / 3) * e;
    e = 1.0 + x * (1.0 / 2) * e;
    e = 1.0 + x * e;
    e *= e;
    e *= e;
    e *= e;
    e *= e;
    const double tail = (double(~word) + 0.5) * 0x1p-32;
    double p = e, above = 1.0 - e;
    int count = 0;
#pragma unroll 1
    while (tail < above && count < 63) {
        p *= lam * INVERSE[++count];
        above -= p;
    }
    return float(count);
}

__device__ inline float counts(float y, float k, u32 word) {
    const float mean = y > 0.0f ? y / k : 0.0f;
    return k * (mean < INVERTED_BELOW ? few(word, mean) : many(word, mean)) + (y < 0.0f ? y : 0.0f);
}

// Whether a telegraph signal is in its upper level: ``keys`` are pairs (is it drawn anew, is it up)
// of frames one after another, ``last`` the present one; the first pair is always drawn anew.
__device__ inline float telegraph(const u64* keys, u32 last, double renew, float occupancy,
                                  u32 index) {
    u32 n = last;
    while (n > 0 && !(uniform(word(__ldg(keys + 2 * n), index)) < renew)) --n;
    return uniform(word(__ldg(keys + 2 * n + 1), index)) < occupancy ? 1.0f : 0.0f;
}

// Values of a few pixels: ``place`` is a pixel's place among them, negative for all others.
__device__ inline float sparse(const float* values, int place, float otherwise) {
    return place < 0 ? otherwise : __ldg(values + place);
}

// The 3x3 pixels around a pixel; beyond the frame's edge its outermost pixels are repeated.
struct Square {
    float up[3], here[3], down[3];
};

__device__ inline Square around(const float* field, u32 row, u32 column, u32 rows, u32 columns) {
    const float* const line = field + size_t(row) * columns;
    const float* const above = row > 0 ? line - columns : line;
    const float* const below = row + 1 < rows ? line + columns : line;
    const u32 at[3] = {column > 0 ? column - 1 : 0, column,
                       column + 1 < columns ? column + 1 : column};
    Square s;
    for (int i = 0; i < 3; ++i) {
        s.up[i] = __ldg(above + at[i]);
        s.here[i] = __ldg(line + at[i]);
        s.down[i] = __ldg(below + at[i]);
    }
    return s;
}

__device__ inline float share(Square s, float edge, float corner, float uneven) {
    const float centre = 1.0f - 4.0f * edge - 4.0f * corner;
    const float sides = s.up[1] + s.down[1], along = s.here[0] + s.here[2];
    return centre * s.here[1] + edge * (sides + along)
           + corner * ((s.up[0] + s.down[0]) + (s.up[2] + s.down[2]))
           + uneven * (along - sides);
}

__device__ inline float kernel_mean(Square s, float phi) {
    const float a = s.up[0] + s.here[0] + s.down[0];
    const float b = s.up[1] + s.here[1] + s.down[1];
    const float c = s.up[2] + s.here[2] + s.down[2];
    return phi * (a + b + c) + (1.0f - 9.0f * phi) * s.here[1];
}

__device__ inline float kernel_norm(Square s) {
    float square[3];
    for (int i = 0; i < 3; ++i)
        square[i] = s.up[i] * s.up[i] + s.here[i] * s.here[i] + s.down[i] * s.down[i];
    return sqrtf(square[0] + square[1] + square[2]);
}

// A code of so many bits, as it is stored.
__device__ inline float code(float y, float top) {
    y = rintf(y);
    y = y > 0.0f ? y : 0.0f;
    return y < top ? y : top;
}

// A scalar or an address out of the table of numbers.
__device__ inline float scalar(u64 number) { return __int_as_float(int(u32(number))); }
