// SPDX-License-Identifier: MIT
//
// What a B-spline, an extruded or a turned surface is, by points and normals: all normals of a
// sphere go through its middle, p - r n = c, those of a cylinder through its axis, planes of a cone
// through its apex, and on a torus p - r n is a circle. Each is a linear problem; who asks checks
// that the samples lie on the answer.
#include "surface.hpp"

#include <math_Jacobi.hxx>
#include <math_Matrix.hxx>
#include <math_SVD.hxx>
#include <math_Vector.hxx>

#include <cmath>

namespace cad
{

static gp_XYZ mean_of(const std::vector<gp_XYZ> &points)
{
    gp_XYZ sum(0, 0, 0);
    for (const gp_XYZ &point : points)
        sum += point;
    return sum / static_cast<double>(points.size());
}

// Least squares of rows * x = right.
static bool solve(const math_Matrix &rows, const math_Vector &right, math_Vector &x)
{
    math_SVD svd(rows);
    if (!svd.IsDone())
        return false;
    svd.Solve(right, x, 1e-13);
    return true;
}

// The directions in which points about `middle` spread the least, and how much: eigenvalues per
// point, ascending.
static std::array<gp_XYZ, 3> spread_of(const std::vector<gp_XYZ> &points, const gp_XYZ &middle,
                                       double values[3])
{
    math_Matrix sums(1, 3, 1, 3, 0.0);
    for (const gp_XYZ &point : points)
        for (int i = 1; i <= 3; ++i)
            for (int j = 1; j <= 3; ++j)
                sums(i, j) += (point - middle).Coord(i) * (point - middle).Coord(j) /
                              static_cast<double>(points.size());
    math_Jacobi eigen(sums);
    std::array<gp_XYZ, 3> vectors;
    for (int k = 1; k <= 3; ++k) { // math_Jacobi has them descending
        math_Vector v(1, 3);
        eigen.Vector(4 - k, v);
        vectors[static_cast<std::size_t>(k - 1)] = gp_XYZ(v(1), v(2), v(3));
        values[k - 1] = eigen.Value(4 - k);
    }
    // math_Jacobi stops early: one step of least squares makes the first what it should be.
    const int n = static_cast<int>(points.size());
    math_Matrix rows(1, n + 1, 1, 3);
    math_Vector right(1, n + 1, 0.0), turn(1, 3);
    for (int k = 0; k <= n; ++k) {
        const gp_XYZ row = k < n ? points[static_cast<std::size_t>(k)] - middle
                                 : vectors[0] * std::sqrt(values[2] * n);
        for (int i = 1; i <= 3; ++i)
            rows(k + 1, i) = row.Coord(i);
        right(k + 1) = k < n ? -(row * vectors[0]) : 0;
    }
    if (solve(rows, right, turn))
        vectors[0] = (vectors[0] + gp_XYZ(turn(1), turn(2), turn(3))).Normalized();
    return vectors;
}

// p - r n = c for all, across the axis alone where there is one.
static bool fit_round(const std::vector<Sample> &samples, const gp_XYZ *axis, gp_XYZ &middle,
                      double &radius)
{
    const int n = static_cast<int>(samples.size());
    gp_XYZ base(0, 0, 0);
    for (const Sample &sample : samples)
        base += sample.point / n;
    math_Matrix rows(1, 3 * n, 1, 4, 0.0);
    math_Vector right(1, 3 * n), x(1, 4);
    for (int k = 0; k < n; ++k) {
        gp_XYZ point = samples[static_cast<std::size_t>(k)].point - base;
        if (axis)
            point -= *axis * (point * *axis);
        for (int i = 1; i <= 3; ++i) {
            rows(3 * k + i, i) = 1;
            rows(3 * k + i, 4) = samples[static_cast<std::size_t>(k)].normal.Coord(i);
            right(3 * k + i) = point.Coord(i);
        }
    }
    if (!solve(rows, right, x))
        return false;
    middle = base + gp_XYZ(x(1), x(2), x(3));
    radius = std::abs(x(4));
    return true;
}

static bool fit_apex(const std::vector<Sample> &samples, gp_XYZ &apex)
{
    const int n = static_cast<int>(samples.size());
    math_Matrix rows(1, n, 1, 3, 0.0);
    math_Vector right(1, n), x(1, 3);
    const gp_XYZ base = samples.front().point;
    for (int k = 0; k < n; ++k) {
        const Sample &sample = samples[static_cast<std::size_t>(k)];
        for (int i = 1; i <= 3; ++i)
            rows(k + 1, i) = sample.normal.Coord(i);
        right(k + 1) = sample.normal * (sample.point - base);
    }
    if (!solve(rows, right, x))
        return false;
    apex = base + gp_XYZ(x(1), x(2), x(3));
    return true;
}

static Surface fit_torus(const std::vector<Sample> &samples, double minor)
{
    std::vector<Sample> ring;
    std::vector<gp_XYZ> points;
    for (const Sample &sample : samples)
        points.push_back(sample.point - sample.normal * minor);
    double values[3];
    gp_XYZ middle = mean_of(points);
    const gp_XYZ axis = spread_of(points, middle, values)[0];
    // A circle through the points: |p|^2 - 2 p c = const, in its plane.
    const int n = static_cast<int>(points.size());
    math_Matrix rows(1, n + 1, 1, 4, 0.0);
    math_Vector right(1, n + 1, 0.0), x(1, 4);
    for (int k = 0; k < n; ++k) {
        const gp_XYZ p = points[static_cast<std::size_t>(k)] - middle;
        for (int i = 1; i <= 3; ++i)
            rows(k + 1, i) = 2 * p.Coord(i);
        rows(k + 1, 4) = 1;
        right(k + 1) = p * p;
    }
    for (int i = 1; i <= 3; ++i)
        rows(n + 1, i) = axis.Coord(i);
    if (!solve(rows, right, x))
        return {};
    const gp_XYZ offset(x(1), x(2), x(3));
    const double major = std::sqrt(std::max(0.0, x(4) + offset * offset));
    Surface out{Kind::torus, middle + offset, axis, major, std::abs(minor)};
    return out.radius2 < out.radius1 ? out : Surface();
}

Surface fit_surface(const std::vector<Sample> &samples, double minor)
{
    if (samples.size() < 9)
        return {};
    std::vector<gp_XYZ> normals;
    for (const Sample &sample : samples)
        normals.push_back(sample.normal);
    double values[3], about[3];
    const gp_XYZ middle = mean_of(normals);
    const auto directions = spread_of(normals, gp_XYZ(0, 0, 0), values);
    const auto tips = spread_of(normals, middle, about);
    constexpr double none = 1e-14; // of squared sines
    Surface out;
    if (about[2] < none)
        return {Kind::plane, samples.front().point, middle.Normalized()};
    if (values[0] < none) {
        out = {Kind::cylinder, gp_XYZ(), directions[0]};
        return fit_round(samples, &out.axis, out.origin, out.radius1) ? out : Surface();
    }
    if (about[0] < none) {
        out = {Kind::cone, gp_XYZ(), tips[0]};
        if (!fit_apex(samples, out.origin))
            return {};
        // The axis along which the radius grows, from the apex.
        if ((samples.front().point - out.origin) * out.axis < 0)
            out.axis.Reverse();
        out.radius2 = std::asin(std::min(1.0, std::abs(middle * out.axis)));
        return out;
    }
    out.kind = Kind::sphere;
    if (fit_round(samples, nullptr, out.origin, out.radius1)) {
        double value;
        gp_XYZ gradient;
        bool good = true;
        for (const Sample &sample : samples)
            good = good && distance(out, sample.point, value, gradient) &&
                   std::abs(value) <= exactness;
        if (good)
            return out;
    }
    return minor != 0 ? fit_torus(samples, minor) : Surface();
}

} // namespace cad
