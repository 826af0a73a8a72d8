// base/strip_program.cpp: compiles expressions to instructions on registers, each a loop over a chunk of points.
#include "base/expression_graph.hpp"

namespace drover {

namespace {
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
double strip_value(double a, double b, double c) {
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
StripKernel strip_kernel(StripOperation operation, bool a, bool b, bool c) {
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

constexpr std::size_t max_instructions = 4096;
constexpr std::size_t scratch_size = 4096;  // numbers in the registers: 32 KB, the size of a first-level cache
constexpr std::size_t max_chunk = 128;      // points: long enough to hide the call of a kernel

struct Argument {
    enum class Kind : std::uint8_t { none, constant, slot, instruction, output };
    Kind kind = Kind::none;
    int index = 0;
};

struct Instruction {
    StripOperation kind = StripOperation::apply;
    Operation operation = Operation::add;  ///< of kind apply
    Argument a = {}, b = {}, c = {};
    int output = -1;         ///< the result is stored here, or
    std::size_t target = 0;  ///< in this register
    int previous = -1;       ///< with an output: the instruction before this one that has it; -1: none
};
}  // namespace

struct StripProgram::Code {
    std::vector<Instruction> instructions;
    std::vector<double> constants;
    std::vector<double> constant_parts;  ///< of each output, with which it begins
    std::vector<int> last;               ///< of each output: its last instruction; -1: none
    std::size_t chunk = max_chunk;
};

namespace {
class Compiler {
public:
    explicit Compiler(std::span<const Expression> outputs) : graph_(Folding::lenient) {
        for (const Expression& output : outputs) roots_.push_back(lowered(output.graph()));
        uses_ = graph_.uses(roots_);
        emitted_.assign(static_cast<std::size_t>(graph_.size()), -1);
        for (std::size_t k = 0; k < roots_.size(); ++k) accumulate(static_cast<int>(k), roots_[k]);
        allocate_registers();
    }
    StripProgram::Code code;

private:
    /// What computes a node: arguments are nodes.
    struct Plan {
        StripOperation kind = StripOperation::apply;
        int a = -1, b = -1, c = -1;
    };

    /// The root of a graph in ours, with natural powers as products.
    int lowered(const Expression::Graph& graph) {
        const auto make = [this](Operation operation, int left, int right) {
            return operation == Operation::power ? power(left, right) : graph_.make(operation, left, right);
        };
        const auto slot = [this](int index) { return graph_.slot(index); };
        return graph_.import(graph, slot, make);
    }
    int power(int base, int exponent) {
        constexpr double max_factors = 64.0;
        const double n = graph_[exponent].value, size = std::abs(n);
        if (!graph_.is_number(exponent) || size > max_factors) return graph_.make(Operation::power, base, exponent);
        if (size == 0.5) {
            const int root = graph_.make(Operation::sqrt, base);
            return n > 0.0 ? root : graph_.make(Operation::divide, graph_.number(1.0), root);
        }
        if (size != std::floor(size) || size == 0.0) return graph_.make(Operation::power, base, exponent);
        int result = -1, square = base;
        for (unsigned bits = static_cast<unsigned>(size); bits > 0; bits >>= 1u) {
            if (bits & 1u) result = result < 0 ? square : graph_.make(Operation::multiply, result, square);
            if (bits > 1u) square = graph_.make(Operation::multiply, square, square);
        }
        return n > 0.0 ? result : graph_.make(Operation::divide, graph_.number(1.0), result);
    }

    bool is_used_once(int node) const { return uses_[static_cast<std::size_t>(node)] == 1; }
    /// A product that no one else needs is part of the sum that needs it.
    bool is_fused(int node) const { return graph_[node].operation == Operation::multiply && is_used_once(node); }

    Plan plan(int index) const {
        const Node& node = graph_[index];
        const int a = node.left, b = node.right;
        switch (node.operation) {
            case Operation::add:
                if (is_fused(b)) return {StripOperation::multiply_add, graph_[b].left, graph_[b].right, a};
                if (is_fused(a)) return {StripOperation::multiply_add, graph_[a].left, graph_[a].right, b};
                return {StripOperation::add, a, b};
            case Operation::subtract:
                if (is_fused(b)) return {StripOperation::subtract_product, graph_[b].left, graph_[b].right, a};
                if (is_fused(a)) return {StripOperation::multiply_subtract, graph_[a].left, graph_[a].right, b};
                return {StripOperation::subtract, a, b};
            case Operation::multiply: return {StripOperation::multiply, a, b};
            case Operation::divide: return {StripOperation::divide, a, b};
            default: return {StripOperation::apply, a, b};
        }
    }

    /// Emits what computes a node, its arguments first; without recursion, which a long sum could make too deep.
    void emit_value(int root) {
        std::vector<int> waiting{root};
        while (!waiting.empty()) {
            const int node = waiting.back();
            if (is_leaf(graph_[node]) || emitted_[static_cast<std::size_t>(node)] >= 0) {
                waiting.pop_back();
                continue;
            }
            const Plan planned = plan(node);
            const std::size_t before = waiting.size();
            for (const int argument : {planned.c, planned.b, planned.a})
                if (argument >= 0 && !is_leaf(graph_[argument]) && emitted_[static_cast<std::size_t>(argument)] < 0)
                    waiting.push_back(argument);
            if (waiting.size() > before) continue;
            waiting.pop_back();
            emitted_[static_cast<std::size_t>(node)] = static_cast<int>(code.instructions.size());
            emit({.kind = planned.kind,
                  .operation = graph_[node].operation,
                  .a = argument(planned.a),
                  .b = argument(planned.b),
                  .c = argument(planned.c)});
        }
    }

    /// out += root, summand by summand.
    void accumulate(int output, int root) {
        struct Summand {
            int node;
            bool is_positive;
        };
        std::vector<Summand> waiting{{root, true}};
        double constant = 0.0;
        while (!waiting.empty()) {
            const auto [index, is_positive] = waiting.back();
            waiting.pop_back();
            const Node node = graph_[index];
            const Argument sum{Argument::Kind::output, output};
            if (graph_.is_number(index)) {
                constant += is_positive ? node.value : -node.value;
                continue;
            }
            const bool is_ours = is_used_once(index);
            if (is_ours && (node.operation == Operation::add || node.operation == Operation::subtract)) {
                waiting.push_back({node.right, is_positive == (node.operation == Operation::add)});
                waiting.push_back({node.left, is_positive});
            } else if (is_ours && node.operation == Operation::negate) {
                waiting.push_back({node.left, !is_positive});
            } else if (is_ours && node.operation == Operation::multiply) {
                emit_value(node.left);
                emit_value(node.right);
                emit({.kind = is_positive ? StripOperation::multiply_add : StripOperation::subtract_product,
                      .a = argument(node.left),
                      .b = argument(node.right),
                      .c = sum,
                      .output = output});
            } else {
                emit_value(index);
                emit({.kind = is_positive ? StripOperation::add : StripOperation::subtract,
                      .a = sum,
                      .b = argument(index),
                      .output = output});
            }
        }
        code.constant_parts.push_back(constant);
        code.last.push_back(last_of_output_);
        last_of_output_ = -1;
    }

    void emit(const Instruction& instruction) {
        require(code.instructions.size() < max_instructions, {},
                "the expressions have more than {} operations together; expected shorter ones", max_instructions);
        code.instructions.push_back(instruction);
        if (instruction.output < 0) return;
        code.instructions.back().previous = last_of_output_;
        last_of_output_ = static_cast<int>(code.instructions.size()) - 1;
    }
    Argument argument(int index) {
        if (index < 0) return {};
        const Node& node = graph_[index];
        if (node.operation == Operation::slot) return {Argument::Kind::slot, node.left};
        if (node.operation != Operation::number)
            return {Argument::Kind::instruction, emitted_[static_cast<std::size_t>(index)]};
        code.constants.push_back(node.value);
        return {Argument::Kind::constant, static_cast<int>(code.constants.size()) - 1};
    }

    /// A register is free again after the last instruction that reads it, which may write its result there.
    void allocate_registers() {
        std::vector<std::size_t> last_use(code.instructions.size(), 0);
        for (std::size_t i = 0; i < code.instructions.size(); ++i)
            for (const Argument& read : {code.instructions[i].a, code.instructions[i].b, code.instructions[i].c})
                if (read.kind == Argument::Kind::instruction) last_use[static_cast<std::size_t>(read.index)] = i;
        std::vector<std::size_t> free;
        std::size_t registers = 0;
        for (std::size_t i = 0; i < code.instructions.size(); ++i) {
            Instruction& instruction = code.instructions[i];
            for (const Argument& read : {instruction.a, instruction.b, instruction.c}) {
                if (read.kind != Argument::Kind::instruction) continue;
                const auto source = static_cast<std::size_t>(read.index);
                if (last_use[source] != i) continue;
                last_use[source] = max_instructions;  // an argument given twice is freed once
                free.push_back(code.instructions[source].target);
            }
            if (instruction.output >= 0) continue;
            if (free.empty()) free.push_back(registers++);
            instruction.target = free.back();
            free.pop_back();
        }
        code.chunk = std::min(max_chunk, scratch_size / std::max<std::size_t>(registers, 1));
    }

    GraphBuilder graph_;
    std::vector<int> roots_, uses_;
    std::vector<int> emitted_;  ///< node -> the instruction that computes it
    int last_of_output_ = -1;   ///< the last instruction of the output that is being compiled
};

/// An argument at one call: its first number, whether it varies between points, and whether it moves with the chunks.
struct Source {
    const double* first;
    bool varies, moves;
};

struct Step {
    StripKernel kernel;
    Operation operation;
    Source a, b, c;
    double* target;
    bool target_moves;
};

const double* at(const Source& source, std::size_t offset) {
    return source.moves ? source.first + offset : source.first;
}
}  // namespace

StripProgram::StripProgram(std::span<const Expression> outputs)
    : code_(std::make_shared<const Code>(Compiler(outputs).code)) {}

void StripProgram::write(std::size_t size, std::span<const double* const> slots, std::span<const double> uniform,
                         std::span<double* const> out) const {
    const Code& code = *code_;
    static constexpr double unused = 0.0;
    alignas(64) std::array<double, scratch_size> registers;
    std::array<double, max_instructions> constant_results;
    std::array<bool, max_instructions> is_constant;
    std::array<Step, max_instructions> steps;
    std::size_t count = 0;
    const auto source_of = [&](const Argument& argument, int previous) -> Source {
        auto index = static_cast<std::size_t>(argument.index);
        switch (argument.kind) {
            case Argument::Kind::none: return {&unused, false, false};
            case Argument::Kind::constant: return {&code.constants[index], false, false};
            case Argument::Kind::slot:
                return slots[index] ? Source{slots[index], true, true} : Source{&uniform[index], false, false};
            case Argument::Kind::output:
                if (previous < 0) return {&code.constant_parts[index], false, false};
                if (!is_constant[static_cast<std::size_t>(previous)]) return {out[index], true, true};
                index = static_cast<std::size_t>(previous);
                break;
            case Argument::Kind::instruction: break;
        }
        if (is_constant[index]) return {&constant_results[index], false, false};
        return {&registers[code.instructions[index].target * code.chunk], true, false};
    };
    for (std::size_t i = 0; i < code.instructions.size(); ++i) {
        const Instruction& instruction = code.instructions[i];
        const Source a = source_of(instruction.a, instruction.previous),
                     b = source_of(instruction.b, instruction.previous),
                     c = source_of(instruction.c, instruction.previous);
        const StripKernel kernel = strip_kernel(instruction.kind, a.varies, b.varies, c.varies);
        is_constant[i] = !a.varies && !b.varies && !c.varies;  // then it is computed once
        double* const target = instruction.output >= 0 ? out[static_cast<std::size_t>(instruction.output)]
                                                       : &registers[instruction.target * code.chunk];
        if (is_constant[i]) kernel(1, instruction.operation, a.first, b.first, c.first, &constant_results[i]);
        else steps[count++] = {kernel, instruction.operation, a, b, c, target, instruction.output >= 0};
    }
    for (std::size_t k = 0; k < out.size(); ++k) {
        const int last = code.last[k];
        if (last < 0) std::fill_n(out[k], size, code.constant_parts[k]);
        else if (const auto i = static_cast<std::size_t>(last); is_constant[i])
            std::fill_n(out[k], size, constant_results[i]);
    }
    for (std::size_t offset = 0; offset < size; offset += code.chunk) {
        const std::size_t points = std::min(code.chunk, size - offset);
        for (std::size_t s = 0; s < count; ++s) {
            const Step& step = steps[s];
            step.kernel(points, step.operation, at(step.a, offset), at(step.b, offset), at(step.c, offset),
                        step.target_moves ? step.target + offset : step.target);
        }
    }
}

}  // namespace drover
