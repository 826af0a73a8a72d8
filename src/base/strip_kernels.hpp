// base/strip_kernels.hpp: loops over a chunk of points for the instructions of StripProgram.
#pragma once
#include "base/expression_graph.hpp"

namespace drover {

/// What an instruction does with its arguments a, b, c.
enum class StripOperation : std::uint8_t {
    apply,              ///< the operation of the instruction on a, b
    add,                ///< a + b
    subtract,           ///< a - b
    multiply,           ///< a b
    divide,             ///< a / b
    multiply_add,       ///< c + a b
    multiply_subtract,  ///< a b - c
    subtract_product    ///< c - a b
};

/// One argument or result at a chunk: an array, or one number for all points.
using StripKernel = void (*)(std::size_t size, Operation operation, const double* a, const double* b, const double* c,
                             double* out);

template <StripOperation operation>
inline double strip_value(double a, double b, double c) {
    if constexpr (operation == StripOperation::add) return a + b;
    if constexpr (operation == StripOperation::subtract) return a - b;
    if constexpr (operation == StripOperation::multiply) return a * b;
    if constexpr (operation == StripOperation::divide) return a / b;
    if constexpr (operation == StripOperation::multiply_add) return c + a * b;
    if constexpr (operation == StripOperation::multiply_subtract) return a * b - c;
    return c - a * b;
}

/// out may be one of the arguments: every point depends on itself alone.
template <StripOperation operation, bool a_varies, bool b_varies, bool c_varies>
void strip_loop(std::size_t size, Operation, const double* a, const double* b, const double* c, double* out) {
    const double a0 = *a, b0 = *b, c0 = *c;
#pragma GCC ivdep
#pragma GCC unroll 4  // of the vector loop: its counting costs as much as its arithmetic
    for (std::size_t i = 0; i < size; ++i)
        out[i] = strip_value<operation>(a_varies ? a[i] : a0, b_varies ? b[i] : b0, c_varies ? c[i] : c0);
}

/// Functions: those without a library call in a loop that vectorises.
template <bool a_varies, bool b_varies>
void strip_function(std::size_t size, Operation operation, const double* a, const double* b, const double*,
                    double* out) {
    const double a0 = *a, b0 = *b;
    const auto loop = [&](auto&& value) {
#pragma GCC ivdep
        for (std::size_t i = 0; i < size; ++i) out[i] = value(a_varies ? a[i] : a0, b_varies ? b[i] : b0);
    };
    switch (operation) {
        case Operation::negate: loop([](double x, double) { return -x; }); break;
        case Operation::abs: loop([](double x, double) { return std::abs(x); }); break;
        case Operation::sqrt: loop([](double x, double) { return std::sqrt(x); }); break;
        case Operation::step: loop([](double x, double) { return x > 0.0 ? 1.0 : 0.0; }); break;
        case Operation::max: loop([](double x, double y) { return x < y ? y : x; }); break;
        case Operation::min: loop([](double x, double y) { return y < x ? y : x; }); break;
        default: loop([operation](double x, double y) { return apply(operation, x, y); }); break;
    }
}

template <StripOperation operation>
StripKernel strip_kernel_of(bool a, bool b, bool c) {
    constexpr std::array<StripKernel, 8> kernels{
        strip_loop<operation, false, false, false>, strip_loop<operation, true, false, false>,
        strip_loop<operation, false, true, false>,  strip_loop<operation, true, true, false>,
        strip_loop<operation, false, false, true>,  strip_loop<operation, true, false, true>,
        strip_loop<operation, false, true, true>,   strip_loop<operation, true, true, true>};
    return kernels[(a ? 1u : 0u) + (b ? 2u : 0u) + (c ? 4u : 0u)];
}

/// The loop for arguments that vary between points or do not.
inline StripKernel strip_kernel(StripOperation operation, bool a, bool b, bool c) {
    switch (operation) {
        case StripOperation::add: return strip_kernel_of<StripOperation::add>(a, b, false);
        case StripOperation::subtract: return strip_kernel_of<StripOperation::subtract>(a, b, false);
        case StripOperation::multiply: return strip_kernel_of<StripOperation::multiply>(a, b, false);
        case StripOperation::divide: return strip_kernel_of<StripOperation::divide>(a, b, false);
        case StripOperation::multiply_add: return strip_kernel_of<StripOperation::multiply_add>(a, b, c);
        case StripOperation::multiply_subtract: return strip_kernel_of<StripOperation::multiply_subtract>(a, b, c);
        case StripOperation::subtract_product: return strip_kernel_of<StripOperation::subtract_product>(a, b, c);
        case StripOperation::apply: break;
    }
    return a && b ? strip_function<true, true> : a ? strip_function<true, false> : strip_function<false, true>;
}

}  // namespace drover
