// base/expression_parse.cpp: formulas of scalars as expressions.
#include <algorithm>
#include <numbers>

#include "base/expression_graph.hpp"
#include "base/formula.hpp"

namespace drover {

namespace {
/// Nodes of a formula in a graph, the operations in the order of the text.
class Reader {
public:
    Reader(const FormulaText& the_text, const Vocabulary& vocabulary)
        : source_(the_text), vocabulary_(vocabulary), graph_(Folding::exact) {}

    Expression read() {
        const Notation notation{.arguments_of = function_arguments,
                                .is_operator = [](const std::string&) { return false; }};
        return graph_.expression(node_of(parse_formula(source_, notation)));
    }

private:
    using Kind = Formula::Kind;

    int make(std::size_t at, Operation operation, int left, int right = -1) {
        graph_.where = source_.location(at);
        return graph_.make(operation, left, right);
    }
    int node_of(const Formula& f) {
        const auto argument = [&](std::size_t i) { return node_of(f.arguments[i]); };
        switch (f.kind) {
            case Kind::number: graph_.where = source_.location(0); return graph_.number(f.value);
            case Kind::name: return named(f);
            case Kind::sum:
            case Kind::product: return folded(f);
            case Kind::negative: return make(f.at, Operation::negate, argument(0));
            case Kind::power: {
                const int base = argument(0);
                return make(f.at, Operation::power, base, argument(1));
            }
            case Kind::call: {
                const int first = argument(0);
                return make(f.at, find_function(f.name)->operation, first, f.arguments.size() > 1 ? argument(1) : -1);
            }
            case Kind::dot:
            case Kind::double_dot:
            case Kind::norm:
            case Kind::operation: break;
        }
        source_.fail(f.at, "an operator on numbers: +, -, *, / or ^");
    }
    int folded(const Formula& f) {
        int result = -1;
        for (const Formula& part : f.arguments) {
            const int node = node_of(part);
            const Operation operation = part.sign == '+'   ? Operation::add
                                        : part.sign == '-' ? Operation::subtract
                                        : part.sign == '*' ? Operation::multiply
                                                           : Operation::divide;
            result = result < 0 ? node : make(part.sign_at, operation, result, node);
        }
        return result;
    }
    int named(const Formula& f) {
        graph_.where = source_.location(f.at);
        if (const auto found = vocabulary_.variables.find(f.name); found != vocabulary_.variables.end())
            return graph_.slot(found->second);
        if (const auto found = vocabulary_.constants.find(f.name); found != vocabulary_.constants.end())
            return graph_.number(found->second);
        if (f.name == "pi") return graph_.number(std::numbers::pi);
        source_.fail(f.at, name_expected(f.name));
    }
    std::string name_expected(const std::string& name) const {
        std::vector<std::string> names, functions;
        for (const auto& [known, slot] : vocabulary_.variables) names.push_back(known);
        for (const auto& [known, value] : vocabulary_.constants) names.push_back(known);
        names.emplace_back("pi");
        for (const FunctionName& function : function_names) functions.emplace_back(function.name);
        std::vector<std::string> all = names;
        all.insert(all.end(), functions.begin(), functions.end());
        return text("{}one of {}, or a function: {}", suggestion(name, all, "", "{} (did you mean that?), "),
                    joined(names), joined(functions));
    }

    const FormulaText& source_;
    const Vocabulary& vocabulary_;
    GraphBuilder graph_;
};
}  // namespace

const FunctionName* find_function(const std::string& name) {
    const auto found =
        std::ranges::find_if(function_names, [&](const FunctionName& function) { return name == function.name; });
    return found == function_names.end() ? nullptr : &*found;
}

int function_arguments(const std::string& name) {
    const FunctionName* function = find_function(name);
    return function == nullptr ? 0 : function->arguments;
}

Expression parse_expression(const std::string& text, const Vocabulary& vocabulary, const SourceLocation& where) {
    return Reader(FormulaText(text, where), vocabulary).read();
}

}  // namespace drover
