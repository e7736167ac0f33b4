"""Chapter 10 of the Modelica Language Specification, 3.6: arrays."""

import numpy as np
from corpus.case import constant, ramp, rule

A = np.array([[1.0, 2.0], [3.0, 4.0]])


def _solve(t: float) -> np.ndarray:
    return np.linalg.solve(A + t * np.eye(2), [1.0, 2.0])


RULES = [
    rule(
        "10.1 arrays of three dimensions",
        "model M Real a[2, 3, 2]; Real y = a[2, 3, 1] + 10*sum(a[1, :, 2]); equation for i in 1:2, j in 1:3, k in 1:2 loop\n"
        "a[i, j, k] = i + 2*j + 4*k*time; end for; end M;",
        y=lambda t: 2 + 6 + 4 * t + 10 * sum(1 + 2 * j + 8 * t for j in (1, 2, 3)),
    ),
    rule(
        "10.1 empty arrays",
        "model M Real a[0]; Real b[0, 3]; parameter Real p[:] = fill(1.0, 0); Real y = time + sum(a) + sum(p) + size(b, 2);"
        " end M;",
        y=lambda t: t + 3,
    ),
    rule(
        "10.2 flexible sizes of function inputs",
        "function own input Real a[:, :]; output Real y; algorithm y := size(a, 1) + 10*size(a, 2) + a[2, 1]; end own;\n"
        "model M Real y = own([1, 2, 3; time, 5, 6]); end M;",
        y=lambda t: 32 + t,
    ),
    rule(
        "10.3.2 size of every dimension",
        "model M Real a[2, 3]; Integer n[2] = size(a); Real y = n[1] + 10*n[2]; equation a = fill(time, 2, 3); end M;",
        y=constant(32),
    ),
    rule(
        "10.3.3 matrices of constructors",
        "model M Real a[2, 2] = diagonal({1, 2}) + identity(2)*time + zeros(2, 2) + 3*ones(2, 2);\n"
        "Real y = a[1, 1] + 10*a[1, 2] + 100*a[2, 2]; end M;",
        y=lambda t: 4 + t + 30 + 100 * (5 + t),
    ),
    rule(
        "10.3.4 reductions of empty arrays",
        "model M Real a[0]; Real y = sum(a) + 10*product(a); end M;",
        y=constant(10),
    ),
    rule(
        "10.3.4 a reduction over an array",
        "model M Real v[3] = {time, 2, 3}; Real y = sum(x^2 for x in v); end M;",
        y=lambda t: t * t + 13,
    ),
    rule(
        "10.3.4 a reduction with a deduced range",
        "model M Real v[3] = {time, 2, 3}; Real y = sum(i*v[i] for i); end M;",
        y=lambda t: t + 13,
    ),
    rule(
        "10.3.4 max and min of states",
        "model M Real v[3](start={0, 0.5, 0.2}, each fixed=true); Real y = max(v) + 10*min(v); equation\n"
        "der(v) = {1, 0, -1}; end M;",
        y=lambda t: max(t, 0.5, 0.2 - t) + 10 * min(t, 0.5, 0.2 - t),
    ),
    rule(
        "10.4.1 constructors of iterators with arrays",
        "model M Real a[3, 2] = {{i, j*time} for j in 1:1, i in 1:3}[:, 1, :]; Real y = a[3, 1]; end M;",
        y=constant(3),
    ),
    rule(
        "10.4.1 an array constructor of vectors",
        "model M Real a[2, 3] = {{1, 2, 3}, {4, 5, 6}*time}; Real y = a[2, 3] + 10*a[1, 2]; end M;",
        y=lambda t: 6 * t + 20,
    ),
    rule(
        "10.4.2 concatenation of matrices and vectors",
        "model M Real v[2] = {time, 2}; Real a[3, 3] = [v, [1, 2; 3, 4]; 5, 6, 7];\n"
        "Real y = a[1, 1] + 10*a[2, 3] + 100*a[3, 2]; end M;",
        y=lambda t: t + 40 + 600,
    ),
    rule(
        "10.4.2 cat along the second dimension",
        "model M Real a[2, 3] = cat(2, [1; 2], [3, 4*time; 5, 6]); Real y = a[1, 3] + 10*a[2, 1]; end M;",
        y=lambda t: 4 * t + 20,
    ),
    rule(
        "10.5 slices of a matrix",
        "model M Real a[3, 3]; Real y = sum(a[2, :]) + 10*sum(a[2:3, 1]) + 100*sum(a[:, 3]); equation\n"
        "a = [1, 2, 3; 4, 5, 6; 7, 8, 9]*time; end M;",
        y=ramp(15 + 110 + 1800),
    ),
    rule(
        "10.5 an index that is an array",
        "model M Real v[4] = {1, 2, 3, 4}*time; Real w[3] = v[{4, 1, 1}]; Real y = w[1] + 10*w[2] + 100*w[3]; end M;",
        y=ramp(114),
    ),
    rule(
        "10.5 end as an index",
        "model M Real v[4] = {1, 2, 3, 4}*time; Real y = v[end] + 10*v[end - 1] + 100*sum(v[2:end]); end M;",
        y=ramp(934),
    ),
    rule(
        "10.5 end in each of two dimensions",
        "model M Real a[2, 3] = [1, 2, 3; 4, 5, 6]*time; Real y = a[end, 1] + 10*a[1, end] + 100*a[end, end]; end M;",
        y=ramp(634),
    ),
    rule(
        "10.5 an index that changes",
        "model M Real v[3] = {5, 7, 9}; Integer i = 1 + integer(2*time); Real y = v[i]; end M;",
        y=lambda t: (5, 7, 9)[int(2 * t)],
    ),
    rule(
        "10.5 an index that changes in an array of states",
        "model M Real v[2](start={0, 5}, each fixed=true); Integer i = if time < 0.5 then 1 else 2; Real y = v[i]; equation\n"
        "der(v) = {1, 2}; end M;",
        y=lambda t: t if t < 0.5 else 5 + 2 * t,
    ),
    rule(
        "10.5 a slice of an array of components",
        "model A parameter Real k = 1; Real z[2] = {k, 2*k}*time; end A; model M A a[3](k={1, 2, 3});\n"
        "Real y = sum(a.z[2]) + 10*sum(a[2:3].k); end M;",
        y=lambda t: 12 * t + 50,
    ),
    rule(
        "10.6.1 equality of matrices as an equation",
        "model M Real a[2, 2]; Real y = a[1, 1] + 10*a[2, 1]; equation 2*a = [2, 4; 6, 8]*time; end M;",
        y=ramp(31),
    ),
    rule(
        "10.6.3 scalar, vector and matrix products",
        "model M Real a[2, 2] = [1, 2; 3, 4]; Real v[2] = {time, 1}; Real y = v*a*v + v*v + 2*v[1]; end M;",
        y=lambda t: float([t, 1] @ A @ [t, 1]) + t * t + 1 + 2 * t,
    ),
    rule(
        "10.6.5 a product with a row and a column",
        "model M Real r[1, 2] = [time, 2]; Real c[2, 1] = [3; 4]; Real y = scalar(r*c); end M;",
        y=lambda t: 3 * t + 8,
    ),
    rule(
        "10.6.7 the power of a square matrix",
        "model M parameter Real a[2, 2] = [1, 2; 3, 4]; Real b[2, 2] = a^3; Real c[2, 2] = a^0;\n"
        "Real y = b[1, 2] + 10*b[2, 1] + 100*c[1, 1] + 1000*c[1, 2]; end M;",
        y=constant(float(np.linalg.matrix_power(A, 3)[0, 1] + 10 * np.linalg.matrix_power(A, 3)[1, 0] + 100)),
    ),
    rule(
        "10.6.9 logical operators of arrays",
        "model M Boolean a[2] = {time > 0.5, true}; Boolean b[2] = not a; Real y = if b[1] then 1 elseif b[2] then 2 else 3;"
        " end M;",
        y=lambda t: 1 if t <= 0.5 else 3,
    ),
    rule(
        "10.6 a linear system in matrix form",
        "model M Real x[2]; Real y = x[1] + 10*x[2]; equation ([1, 2; 3, 4] + time*identity(2))*x = {1, 2}; end M;",
        y=lambda t: float(_solve(t) @ [1, 10]),
    ),
    rule(
        "10.6 states in matrix form",
        "model M parameter Real a[2, 2] = [0, 1; -1, 0]; Real x[2](start={1, 0}, each fixed=true); Real y = x[1]; equation\n"
        "der(x) = a*x; end M;",
        y=lambda t: float(np.cos(t)),
    ),
    rule(
        "10.6.2 sums of scalars and arrays by elements",
        "model M Real v[2] = {1, 2} .+ time; Real w[2] = time .- {1, 2}; Real y = v[2] + 10*w[1]; end M;",
        y=lambda t: 2 + t + 10 * (t - 1),
    ),
    rule(
        "10.6.4 elementwise division by an array",
        "model M Real v[2] = (1 + time) ./ {1, 2}; Real w[2] = {4, 6} ./ 2; Real y = v[2] + 10*w[2]; end M;",
        y=lambda t: (1 + t) / 2 + 30,
    ),
    rule(
        "10.6.8 elementwise powers",
        "model M Real v[2] = {2, 3} .^ 2; Real w[2] = 2 .^ {time, 3}; Real y = sum(v) + w[1] + 100*w[2]; end M;",
        y=lambda t: 13 + 2**t + 800,
    ),
    rule(
        "10.3.4 a range that depends on another iterator",
        "model M Real y = sum(sum(j*time for j in 1:i) for i in 1:4); end M;",
        y=ramp(20),
    ),
    rule(
        "10.5 a slice of an array of components on the left",
        "model A Real z[2]; end A; model M A a[3]; Real y = a[3].z[2] + 10*a[1].z[1]; equation\n"
        "for i in 1:2 loop a.z[i] = {1, 2, 3}*i*time; end for; end M;",
        y=ramp(16),
    ),
]
