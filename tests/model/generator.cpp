// tests/model/generator.cpp: random formulas by rank and parity.
#include "model/generator.hpp"

#include <algorithm>
#include <utility>

namespace drover::model {

namespace {
using Kind = Tree::Kind;
using Binding = Tree::Binding;
using Found = std::optional<Tree>;  // nothing: these fields have no such formula
constexpr int max_degree = 5, max_derivatives = 4;

/// A part as the operand of something that binds as tightly as `least`.
std::string part_text(const Tree& t, Binding least) { return t.binding < least ? "(" + t.text + ")" : t.text; }

class Generator {
public:
    explicit Generator(std::mt19937& random) : random_(random) {}

    RandomModel model() {
        Model& model = result_.model;
        model.chiral = chance(0.2);
        is_anisotropic_ = chance(0.25);
        const bool is_plain = chance(0.4);  // at most two scalars and two vectors with a rate
        const int count = between(1, is_plain ? 4 : 6);
        const bool may_balance = !model.chiral && !is_anisotropic_ && (is_plain || count > 1) && chance(0.4);
        declare_fields(count + (is_plain && may_balance ? 1 : 0), is_plain ? count : 0);
        if (may_balance) model.fields.back().left = LeftSide::balance;
        for (Field& field : model.fields) field.solenoidal = field.spin == 1 && chance(0.3);
        for (std::size_t i = 0; i < model.fields.size(); ++i) write_equation(i);
        return std::move(result_);
    }

private:
    // ---- chances

    int between(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
    bool chance(double p) { return std::uniform_real_distribution<double>()(random_) < p; }
    double number() { return std::round(std::uniform_real_distribution<double>(0.2, 1.5)(random_) * 1000.0) / 1000.0; }
    int any_parity() { return chance(0.5) ? 1 : -1; }
    /// In a chiral model every parity fits.
    int free(int parity) { return result_.model.chiral && chance(0.4) ? -parity : parity; }

    // ---- trees

    static Tree joined(Kind kind, int indices, int spin, std::vector<Tree> parts) {
        Tree t{.kind = kind, .indices = indices, .spin = spin, .parts = std::move(parts)};
        for (const Tree& part : t.parts) {
            t.derivatives += part.derivatives;
            t.is_polynomial = t.is_polynomial && part.is_polynomial;
            t.is_anisotropic = t.is_anisotropic || part.is_anisotropic;
            t.degree = kind == Kind::sum ? std::max(t.degree, part.degree) : t.degree + part.degree;
            t.parity *= part.parity;
        }
        if (kind == Kind::sum) t.parity = t.parts[0].parity;
        return t;
    }
    static Found limited(Tree t) {
        if (t.degree > max_degree || t.derivatives > max_derivatives) return std::nullopt;
        return t;
    }
    Tree coefficient() {
        Tree t{.kind = Kind::number, .value = number()};
        if (chance(0.5)) {
            t.text = text("{}", t.value);
            return t;
        }
        t.text = text("c{}", result_.model.coefficients.size());
        if (chance(0.3)) t.value = -t.value;
        result_.model.coefficients[t.text] = t.value;
        return t;
    }
    Found product(const Found& a, const Found& b) {
        if (!a || !b) return std::nullopt;
        Tree t = joined(Kind::product, a->indices + b->indices, a->spin + b->spin, {*a, *b});
        const std::string first = part_text(*a, Binding::product), second = part_text(*b, Binding::power);
        const bool needs_star = std::isdigit(static_cast<unsigned char>(second[0])) != 0 || second[0] == '-';
        t.text = first + (needs_star || chance(0.3) ? " * " : " ") + second;
        t.binding = Binding::product;
        return limited(t);
    }
    Found sum(const Found& a, const Found& b) {
        if (!a || !b) return std::nullopt;
        const bool minus = chance(0.5);
        Tree second = *b;
        if (minus) second = joined(Kind::negative, b->indices, b->spin, {*b});
        Tree t = joined(Kind::sum, a->indices, a->spin, {*a, second});
        t.text = a->text + (minus ? " - " : " + ") + part_text(*b, Binding::product);
        t.binding = Binding::sum;
        return t;
    }
    Found prefix(Kind kind, const char* name, int indices, int spin, const Found& a) {
        if (!a || (kind != Kind::perp && a->kind == Kind::number)) return std::nullopt;
        Tree t = joined(kind, indices, spin, {*a});
        t.derivatives += kind == Kind::lap ? 2 : kind == Kind::perp || kind == Kind::sym ? 0 : 1;
        if (kind == Kind::curl || kind == Kind::perp) t.parity = -t.parity;
        const bool is_chain = a->binding == Binding::chain || a->binding == Binding::operation_on_chain;
        const bool is_bare = (a->binding > Binding::chain || is_chain) && !(is_chain && chance(0.5)) &&
                             !std::isdigit(static_cast<unsigned char>(a->text[0])) && a->text[0] != '(' &&
                             a->text[0] != '-';
        t.text = std::string(name) + (is_bare ? " " + a->text : "(" + a->text + ")");
        t.binding = is_bare && is_chain ? Binding::operation_on_chain : Binding::operation;
        return limited(t);
    }
    Found dotted(Kind kind, int indices, int spin, const Found& a, const Found& b) {
        if (!a || !b) return std::nullopt;
        Tree t = joined(kind, indices, spin, {*a, *b});
        t.text = part_text(*a, Binding::atom) + (kind == Kind::dot ? "." : ":") + part_text(*b, Binding::operation);
        t.binding = Binding::chain;
        return limited(t);
    }
    Found outer(const Found& a, const Found& b) {
        if (!a || !b) return std::nullopt;
        Tree t = joined(Kind::outer, 1, b->spin, {*a, *b});
        t.text = "outer(" + a->text + ", " + b->text + ")";
        return limited(t);
    }
    Found power(const Found& a, int n) {
        if (!a) return std::nullopt;
        Tree t = joined(Kind::power, 0, 0, {*a});
        t.value = n;
        t.degree *= n;
        t.derivatives *= n;
        if (n % 2 == 0) t.parity = 1;
        t.text = part_text(*a, Binding::atom) + text("^{}", n);
        t.binding = Binding::power;
        return limited(t);
    }
    Found function(const Found& a) {
        if (!a || a->parity < 0 || a->derivatives > 1) return std::nullopt;
        Tree t = joined(Kind::function, 0, 0, {*a});
        constexpr std::array names{"sin", "cos", "tanh"};
        t.name = names[static_cast<std::size_t>(between(0, 2))];
        t.text = t.name + "(" + a->text + ")";
        t.is_polynomial = false;
        return t;
    }
    /// a / (number + b^2).
    Found quotient(const Found& a, const Found& b) {
        const Found below = sum_of_square(b);
        if (!a || !below || a->derivatives + below->derivatives > 2) return std::nullopt;
        Tree t = joined(Kind::quotient, a->indices, a->spin, {*a, *below});
        t.parity = a->parity;
        t.is_polynomial = false;
        t.text = part_text(*a, Binding::product) + " / " + part_text(*below, Binding::power);
        t.binding = Binding::product;
        return t;
    }
    Found sum_of_square(const Found& b) {
        const Found square = power(b, 2);
        if (!square) return std::nullopt;
        Tree one{.kind = Kind::number, .value = number() + 1.0};
        one.text = text("{}", one.value);
        Tree t = joined(Kind::sum, 0, 0, {one, *square});
        t.text = one.text + " + " + square->text;
        t.binding = Binding::sum;
        return t;
    }

    // ---- fields

    void declare_fields(int count, int plain) {
        const int first_plain = between(0, 1);
        int component = 0;
        constexpr std::array letters{"s", "v", "Q", "T"};
        for (int i = 0; i < count; ++i) {
            Field field;
            field.spin = i == 0 && chance(0.5) ? 0 : between(0, 3);
            field.odd = chance(0.3);
            if (i < plain) field.spin = (i + first_plain) % 2, field.odd = false;
            field.symbol = text("{}{}", letters[static_cast<std::size_t>(field.spin)], i);
            field.name = text("field_{}", i);
            if (field.spin == 0 && !field.odd) field.reference = number();
            field.where = {"model", i + 1, 1};
            field.conserved = field.spin == 0 && i > 0 && chance(0.4);
            if (chance(0.4)) {
                field.noise = number();
                field.noise_conserves = field.conserved || chance(0.4);
            }
            first_.push_back(component);
            component += components(field);
            result_.model.fields.push_back(field);
        }
    }
    Tree whole(std::size_t i) const {
        const Field& field = result_.model.fields[i];
        return {.kind = Kind::field,
                .spin = field.spin,
                .index = first_[i],
                .text = field.symbol,
                .parity = field.odd ? -1 : 1,
                .degree = 1};
    }
    Found field(int spin, int parity) {
        std::vector<std::size_t> fitting;
        for (std::size_t i = 0; i < first_.size(); ++i) {
            const Field& candidate = result_.model.fields[i];
            if (candidate.spin == spin && (candidate.odd ? -1 : 1) == parity) fitting.push_back(i);
        }
        if (fitting.empty()) return std::nullopt;
        Tree t = whole(fitting[static_cast<std::size_t>(between(0, static_cast<int>(fitting.size()) - 1))]);
        return t;
    }
    /// One component of a field of a spin.
    Found component() {
        const auto i = static_cast<std::size_t>(between(0, static_cast<int>(first_.size()) - 1));
        const Field& field = result_.model.fields[i];
        if (field.spin == 0) return std::nullopt;
        const int part = between(0, 1);
        return Tree{.kind = Kind::component,
                    .index = first_[i] + part,
                    .text = component_names(field)[static_cast<std::size_t>(part)],
                    .degree = 1,
                    .is_anisotropic = true};
    }
    Found norm() {
        const auto i = static_cast<std::size_t>(between(0, static_cast<int>(first_.size()) - 1));
        const Tree a = whole(i);
        if ((a.spin == 0 && a.parity < 0) || result_.model.fields[i].left == LeftSide::balance)
            return std::nullopt;  // its mean may be 0
        Tree t = joined(Kind::norm, 0, 0, {a});
        t.parity = 1;
        t.degree = 1;
        t.is_polynomial = false;
        t.text = "|" + a.text + "|";
        return t;
    }

    // ---- formulas of a rank and a parity

    Found scalar(int wanted, int depth) {
        for (int attempt = 0; attempt < 12; ++attempt)
            if (Found found = named(one_scalar(free(wanted), depth))) return found;
        return field(0, wanted);
    }
    Found one_scalar(int parity, int depth) {
        const int other = any_parity();
        if (depth <= 0 || chance(0.15)) {
            if (is_anisotropic_ && chance(0.3)) return component();
            return parity > 0 && chance(0.2) ? Found(coefficient()) : field(0, parity);
        }
        switch (between(0, 14)) {
            case 0: return product(scalar(other, depth - 1), scalar(parity * other, depth - 1));
            case 1: return sum(scalar(parity, depth - 1), scalar(parity, depth - 1));
            case 2: return dotted(Kind::dot, 0, 0, of_spin(1, other, depth - 1), of_spin(1, parity * other, depth - 1));
            case 3: {
                const int spin = between(2, 3);
                return dotted(Kind::double_dot, 0, 0, of_spin(spin, other, depth - 1),
                              of_spin(spin, parity * other, depth - 1));
            }
            case 4:
                return dotted(Kind::double_dot, 0, 0, of_spin(2, other, depth - 1),
                              gradient(of_spin(1, parity * other, depth - 1)));
            case 5: return prefix(Kind::div, "div", 0, 0, of_spin(1, parity, depth - 1));
            case 6: return prefix(Kind::curl, "curl", 0, 0, of_spin(1, -parity, depth - 1));
            case 7: return prefix(Kind::lap, "lap", 0, 0, scalar(parity, depth - 1));
            case 8: return parity > 0 ? power(scalar(other, depth - 1), 2) : power(scalar(parity, depth - 1), 3);
            case 9: return parity > 0 ? norm() : dotted(Kind::dot, 0, 0, field(1, other), field(1, -other));
            case 10: return parity > 0 ? function(scalar(1, depth - 1)) : std::nullopt;
            case 11: return quotient(scalar(parity, depth - 1), field(0, other));
            case 12:
                return dotted(Kind::dot, 0, 0, of_spin(1, other, depth - 1),
                              gradient(scalar(parity * other, depth - 1)));
            case 13: return tensor_trace(parity, other, depth);
            default: return is_anisotropic_ ? along_axis(scalar(any_parity(), depth - 1)) : std::nullopt;
        }
    }
    /// (Q.R):grad v, outer(v, w):grad u.
    Found tensor_trace(int parity, int other, int depth) {
        const Found tensor = chance(0.5)
                                 ? dotted(Kind::dot, 1, 1, of_spin(2, other, depth - 2), of_spin(2, parity, depth - 2))
                                 : outer(of_spin(1, other, depth - 2), of_spin(1, parity, depth - 2));
        return dotted(Kind::double_dot, 0, 0, tensor, gradient(of_spin(1, other, depth - 1)));
    }
    Found gradient(const Found& a) {
        if (!a) return std::nullopt;
        return a->spin == 0 ? prefix(Kind::grad, "grad", 0, 1, a) : prefix(Kind::grad, "grad", 1, a->spin, a);
    }
    Found along_axis(const Found& a) {
        if (!a) return std::nullopt;
        const int axis = between(0, 1);
        Found t = prefix(Kind::along_axis, axis == 0 ? "d_x" : "d_y", 0, a->spin, a);
        if (t) t->index = axis, t->is_anisotropic = true;
        return t;
    }

    Found of_spin(int spin, int wanted, int depth) {
        for (int attempt = 0; attempt < 12; ++attempt)
            if (Found found = named(one_of_spin(spin, free(wanted), depth))) return found;
        return field(spin, wanted);
    }
    Found one_of_spin(int spin, int parity, int depth) {
        const int other = any_parity();
        if (depth <= 0 || chance(0.15)) return field(spin, parity);
        switch (between(0, 11)) {
            case 0: return product(scalar(other, depth - 1), of_spin(spin, parity * other, depth - 1));
            case 1: return product(of_spin(spin, parity * other, depth - 1), scalar(other, depth - 1));
            case 2: return sum(of_spin(spin, parity, depth - 1), of_spin(spin, parity, depth - 1));
            case 3: return prefix(Kind::lap, "lap", 0, spin, of_spin(spin, parity, depth - 1));
            case 4: return prefix(Kind::perp, "perp", 0, spin, of_spin(spin, -parity, depth - 1));
            case 5:
                return spin < 3 ? prefix(Kind::div, "div", 0, spin, of_spin(spin + 1, parity, depth - 1))
                                : std::nullopt;
            case 6:
                return dotted(Kind::dot, 0, spin, of_spin(1, other, depth - 1),
                              gradient(of_spin(spin, parity * other, depth - 1)));
            case 7:
                return prefix(Kind::div, "div", 0, spin,
                              outer(of_spin(1, other, depth - 1), of_spin(spin, parity * other, depth - 1)));
            case 8: return quotient(of_spin(spin, parity, depth - 1), field(0, other));
            case 9: return is_anisotropic_ ? along_axis(of_spin(spin, any_parity(), depth - 1)) : std::nullopt;
            default: return spin == 1 ? one_vector(parity, other, depth) : raised(spin, parity, other, depth);
        }
    }
    Found one_vector(int parity, int other, int depth) {
        switch (between(0, is_anisotropic_ ? 4 : 3)) {
            case 0: return gradient(scalar(parity, depth - 1));
            case 1: return dotted(Kind::dot, 0, 1, of_spin(2, other, depth - 1), of_spin(1, parity * other, depth - 1));
            case 2: return dotted(Kind::dot, 0, 1, of_spin(1, other, depth - 1), of_spin(2, parity * other, depth - 1));
            case 3: {
                const Found same = field(1, other);  // v.grad v
                return parity > 0 ? dotted(Kind::dot, 0, 1, same, gradient(same)) : std::nullopt;
            }
            default: {
                const int axis = between(0, 1);
                return product(scalar(any_parity(), depth - 1), Tree{.kind = Kind::unit,
                                                                     .spin = 1,
                                                                     .index = axis,
                                                                     .text = axis == 0 ? "e_x" : "e_y",
                                                                     .is_anisotropic = true});
            }
        }
    }
    /// The symmetric traceless part of a gradient or an outer product.
    Found raised(int spin, int parity, int other, int depth) {
        if (chance(0.5)) return prefix(Kind::sym, "sym", 0, spin, gradient(of_spin(spin - 1, parity, depth - 1)));
        return prefix(Kind::sym, "sym", 0, spin,
                      outer(of_spin(1, other, depth - 1), of_spin(spin - 1, parity * other, depth - 1)));
    }
    /// Some formulas become definitions.
    Found named(Found t) {
        if (!t || t->parts.empty() || !chance(0.06)) return t;
        const std::string name = text("D{}", result_.model.definitions.size());
        result_.model.definitions.push_back({name, {t->text, {"definitions", 1, 1}}});
        t->text = name;
        t->binding = Binding::atom;
        return t;
    }

    // ---- equations

    void write_equation(std::size_t i) {
        Field& field = result_.model.fields[i];
        std::vector<Tree> terms;
        std::optional<Tree> mass;
        if (field.left == LeftSide::balance) {
            terms = balance(i);
            field.noise = 0.0;
            field.conserved = field.noise_conserves = false;
        } else {
            if (!field.conserved && !field.solenoidal && chance(0.3)) mass = mass_of();
            for (int count = between(1, 4); count > 0; --count) {
                Found term = field.conserved ? flux(i) : term_of(i);
                if (mass && term && chance(0.3)) term = product(mass, term);
                if (!term) term = product(coefficient(), prefix(Kind::lap, "lap", 0, field.spin, whole(i)));
                terms.push_back(*term);
            }
        }
        std::string written;
        for (Tree& term : terms) {
            const bool minus = chance(0.5) || (field.left == LeftSide::balance && written.empty());
            written += (minus             ? written.empty() ? "-" : " - "
                        : written.empty() ? ""
                                          : " + ") +
                       part_text(term, Binding::product);
            if (minus) term = joined(Kind::negative, term.indices, term.spin, {term});
            result_.is_polynomial = result_.is_polynomial && term.is_polynomial;
            result_.is_isotropic = result_.is_isotropic && !term.is_anisotropic;
        }
        if (mass) {
            field.mass = {mass->text, {"mass", static_cast<int>(i) + 1, 1}};
            result_.is_polynomial = result_.is_polynomial && mass->degree == 0;
        }
        field.equation = {written, {"model", static_cast<int>(i) + 1, 20}};
        result_.terms.push_back(std::move(terms));
        result_.masses.push_back(std::move(mass));
    }
    Found term_of(std::size_t i) {
        const Field& field = result_.model.fields[i];
        const int parity = field.odd ? -1 : 1, depth = between(1, 3);
        if (chance(0.2))
            return prefix(Kind::lap, "lap", 0, field.spin, prefix(Kind::lap, "lap", 0, field.spin, whole(i)));
        return field.spin == 0 ? scalar(parity, depth) : of_spin(field.spin, parity, depth);
    }
    Found flux(std::size_t i) {
        const int parity = result_.model.fields[i].odd ? -1 : 1, other = any_parity();
        if (chance(0.4)) return prefix(Kind::lap, "lap", 0, 0, scalar(parity, 2));
        if (chance(0.3)) {  // v.grad s + s div v
            const Found v = field(1, other), s = field(0, parity * other);
            const Found carried = dotted(Kind::dot, 0, 0, v, gradient(s)),
                        spread = product(s, prefix(Kind::div, "div", 0, 0, v));
            if (!carried || !spread) return std::nullopt;
            Tree t = joined(Kind::sum, 0, 0, {*carried, *spread});
            t.text = carried->text + " + " + spread->text;
            t.binding = Binding::sum;
            return t;
        }
        return prefix(Kind::div, "div", 0, 0, of_spin(1, parity, 2));
    }
    /// 0 = -c F + K lap F + a linear form of another field.
    std::vector<Tree> balance(std::size_t i) {
        const Tree own = whole(i);
        Tree c{.kind = Kind::number, .value = number()};
        c.text = text("{}", c.value);
        std::vector<Tree> terms{*product(c, own)};
        if (Found other = linear_form(i)) terms.push_back(*other);
        return terms;
    }
    Found linear_form(std::size_t i) {
        const Field& own = result_.model.fields[i];
        for (std::size_t j = 0; j < i; ++j) {
            Found form = whole(j);
            if (form->parity != (own.odd ? -1 : 1)) continue;
            while (form && form->spin > own.spin) form = prefix(Kind::div, "div", 0, form->spin - 1, form);
            while (form && form->spin < own.spin)
                form = form->spin == 0 ? gradient(form) : prefix(Kind::sym, "sym", 0, form->spin + 1, gradient(form));
            if (form) return product(coefficient(), form);
        }
        return std::nullopt;
    }
    /// A positive scalar.
    Found mass_of() {
        Tree m{.kind = Kind::number, .value = number()};
        m.text = text("m{}", result_.model.coefficients.size());
        result_.model.coefficients[m.text] = m.value;
        if (chance(0.3)) return m;
        const Field& last = result_.model.fields.back();  // in balance its mean may be 0
        if (const Found density = field(0, 1);
            density && chance(0.5) && !(last.left == LeftSide::balance && density->text == last.symbol))
            return product(m, density);
        const Found more = sum_of_square(scalar(any_parity(), 1));
        return more && more->derivatives == 0 ? product(m, more) : m;
    }

    std::mt19937& random_;
    RandomModel result_;
    std::vector<int> first_;
    bool is_anisotropic_ = false;
};
}  // namespace

RandomModel random_model(std::mt19937& random) { return Generator(random).model(); }

}  // namespace drover::model
