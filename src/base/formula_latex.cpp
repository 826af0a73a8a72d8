// base/formula_latex.cpp: formulas typeset as LaTeX.
#include <algorithm>
#include <array>

#include "base/formula.hpp"

namespace drover {

namespace {
using Kind = Formula::Kind;
using NameWriter = std::function<std::string(const std::string&)>;

/// How strongly the outermost operation of a text binds.
enum LatexBinding { latex_sum, latex_product, latex_dot, latex_operation, latex_power, latex_atom };

struct Typeset {
    std::string text;
    LatexBinding binding = latex_atom;
};

std::string enclosed(const Typeset& part, LatexBinding at_least) {
    return part.binding >= at_least ? part.text : "\\left(" + part.text + "\\right)";
}

std::string latex_of_number(double value) {
    std::string written = text("{}", value);
    if (const std::size_t e = written.find('e'); e != std::string::npos)
        return written.substr(0, e) + "\\times 10^{" + std::to_string(std::stoi(written.substr(e + 1))) + "}";
    return written;
}

class Typesetter {
public:
    explicit Typesetter(const NameWriter& name) : name_(name) {}

    Typeset of(const Formula& f) const {
        const auto argument = [&](std::size_t i) { return of(f.arguments[i]); };
        switch (f.kind) {
            case Kind::number: return {latex_of_number(f.value)};
            case Kind::name: return {f.name == "pi" ? "\\pi" : name_(f.name)};
            case Kind::sum: return sum(f);
            case Kind::product: return product(f);
            case Kind::negative: return {"-" + enclosed(argument(0), latex_product), latex_sum};
            case Kind::power: return {enclosed(argument(0), latex_atom) + "^{" + argument(1).text + "}", latex_power};
            case Kind::dot:
            case Kind::double_dot:
                // "(grad p).w" needs parentheses, or it would be the gradient of p.w.
                return {enclosed(argument(0), f.arguments[0].kind == Kind::operation ? latex_power : latex_dot) +
                            (f.kind == Kind::dot ? " \\cdot " : " : ") + enclosed(argument(1), latex_dot),
                        latex_dot};
            case Kind::norm: return {"\\left|" + argument(0).text + "\\right|"};
            case Kind::call: return call(f);
            case Kind::operation: return {operation(f.name) + enclosed(argument(0), latex_operation), latex_operation};
        }
        return {};
    }

private:
    Typeset sum(const Formula& f) const {
        std::string written;
        for (const Formula& part : f.arguments) {
            const bool is_first = written.empty();
            if (!is_first) written += part.sign == '-' ? " - " : " + ";
            written += enclosed(of(part), is_first ? latex_sum : latex_product);
        }
        return {written, latex_sum};
    }
    /// "a / b c" is a fraction times c.
    Typeset product(const Formula& f) const {
        std::string written;
        bool is_negative = false;
        for (std::size_t i = 0; i < f.arguments.size(); ++i) {
            const Formula& part = f.arguments[i];
            if (part.sign == '/') {
                written = "\\frac{" + written + "}{" + of(part).text + "}";
                continue;
            }
            const bool minus = i == 0 && part.kind == Kind::negative;
            is_negative = is_negative || minus;
            const std::string next = enclosed(of(minus ? part.arguments[0] : part), latex_dot);
            written += (written.empty() ? "" : "\\, ") + next;
        }
        return {(is_negative ? "-" : "") + written, is_negative ? latex_sum : latex_product};
    }
    Typeset call(const Formula& f) const {
        if (f.name == "outer")
            return {enclosed(of(f.arguments[0]), latex_dot) + " \\otimes " + enclosed(of(f.arguments[1]), latex_dot),
                    latex_product};
        if (f.name == "explicit") return of(f.arguments[0]);  // says how it is solved
        if (f.name == "sqrt") return {"\\sqrt{" + of(f.arguments[0]).text + "}"};
        constexpr std::array own{"cos", "cosh", "exp", "log", "max", "min", "sin", "sinh", "tan", "tanh"};
        const bool is_command = std::ranges::find(own, f.name) != own.end();
        std::string inside;
        for (const Formula& argument : f.arguments) inside += (inside.empty() ? "" : ", ") + of(argument).text;
        return {(is_command ? "\\" + f.name : "\\operatorname{" + f.name + "}") + "\\left(" + inside + "\\right)"};
    }
    static std::string operation(const std::string& name) {
        if (name == "grad") return "\\nabla ";
        if (name == "div") return "\\nabla \\cdot ";
        if (name == "lap") return "\\nabla^2 ";
        if (name == "curl") return "\\nabla \\times ";
        if (name == "d_x" || name == "d_y") return "\\partial_" + name.substr(2) + " ";
        return "\\operatorname{" + name + "} ";
    }

    const NameWriter& name_;
};
}  // namespace

std::string latex_of(const Formula& formula, const NameWriter& name) { return Typesetter(name).of(formula).text; }

std::string latex_of_name(const std::string& name) {
    constexpr std::array greek{"alpha", "beta",   "gamma", "delta", "epsilon", "zeta",  "eta",   "theta",
                               "kappa", "lambda", "mu",    "nu",    "xi",      "rho",   "sigma", "tau",
                               "phi",   "chi",    "psi",   "omega", "Gamma",   "Delta", "Theta", "Lambda",
                               "Xi",    "Sigma",  "Phi",   "Psi",   "Omega"};
    const std::size_t letters = name.find_last_not_of("0123456789") + 1;
    if (letters > 0 && letters < name.size() && name.find('_') == std::string::npos)  // rho1
        return latex_of_name(name.substr(0, letters) + "_" + name.substr(letters));
    const std::size_t underscore = name.find('_');
    const std::string stem = name.substr(0, underscore);
    std::string written = stem.size() == 1 ? stem : "\\mathrm{" + stem + "}";
    if (std::ranges::find(greek, stem) != greek.end()) written = "\\" + stem;
    if (underscore == std::string::npos || underscore + 1 == name.size()) return written;
    std::string index = name.substr(underscore + 1);
    if (index.size() > 1 && !std::ranges::all_of(index, [](unsigned char c) { return std::isdigit(c); }))
        index = "\\mathrm{" + latex_of_name(index) + "}";
    for (std::size_t at = 0; (at = index.find('_', at)) != std::string::npos; at += 2) index.insert(at, "\\");
    return written + "_{" + index + "}";
}

}  // namespace drover
