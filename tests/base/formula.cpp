// tests/base/formula.cpp: the grammar of formulas with vectors and operators.
#include "base/formula.hpp"

#include <gtest/gtest.h>

#include "base/refusal.hpp"

namespace drover::formula_tests {
namespace {

const Notation notation{
    .arguments_of = [](const std::string& name) { return name == "outer" ? 2
                                                         : name == "sin" ? 1
                                                                         : 0; },
    .is_operator =
        [](const std::string& name) { return name == "grad" || name == "div" || name == "lap" || name == "d_x"; }};

/// The tree with all its parentheses.
std::string shape(const Formula& f) {
    std::string inside;
    for (const Formula& part : f.arguments)
        inside += (&part == &f.arguments.front()                                      ? (part.sign == '-' ? "-" : "")
                   : f.kind == Formula::Kind::sum || f.kind == Formula::Kind::product ? std::string(1, part.sign)
                                                                                      : std::string(",")) +
                  shape(part);
    switch (f.kind) {
        case Formula::Kind::number: return text("{}", f.value);
        case Formula::Kind::name: return f.name;
        case Formula::Kind::sum:
        case Formula::Kind::product: return "(" + inside + ")";
        case Formula::Kind::negative: return "-" + inside;
        case Formula::Kind::power: return "pow(" + inside + ")";
        case Formula::Kind::dot: return "dot(" + inside + ")";
        case Formula::Kind::double_dot: return "ddot(" + inside + ")";
        case Formula::Kind::norm: return "norm(" + inside + ")";
        case Formula::Kind::call:
        case Formula::Kind::operation: return f.name + "[" + inside + "]";
    }
    return "";
}

std::string shape(const std::string& written) {
    const SourceLocation nowhere;
    return shape(parse_formula(FormulaText(written, nowhere), notation));
}

TEST(Formula, binds_dots_before_products_and_operators_to_the_next_chain) {
    EXPECT_EQ(shape("b p.p p"), "(b*dot(p,p)*p)");
    EXPECT_EQ(shape("-w p.grad p - K lap lap p"), "((-w*dot(p,grad[p]))-(K*lap[lap[p]]))");
    EXPECT_EQ(shape("p div p"), "(p*div[p])");
    EXPECT_EQ(shape("grad p.p"), "grad[dot(p,p)]");
    EXPECT_EQ(shape("grad(p.p) / 2"), "(grad[dot(p,p)]/2)");
    EXPECT_EQ(shape("grad(phi).p"), "dot(grad[phi],p)");
    EXPECT_EQ(shape("(div Q).p + p.(grad phi)"), "(dot(div[Q],p)+dot(p,grad[phi]))");
    EXPECT_EQ(shape("p.(grad phi).q"), "dot(dot(p,grad[phi]),q)");
    EXPECT_EQ(shape("(p.p)^2 phi^3"), "(pow(dot(p,p),2)*pow(phi,3))");
    EXPECT_EQ(shape("|p| p"), "(norm(p)*p)");
    EXPECT_EQ(shape("2 |p| |q|"), "(2*norm(p)*norm(q))");
    EXPECT_EQ(shape("Q:grad v"), "ddot(Q,grad[v])");
    EXPECT_EQ(shape("div outer(p, p)"), "div[outer[p,p]]");
    EXPECT_EQ(shape("lap(phi^3 - phi - lap phi)"), "lap[(pow(phi,3)-phi-lap[phi])]");
    EXPECT_EQ(shape("a / b c"), "(a/b*c)");
}

TEST(Formula, rejects_what_can_be_read_in_two_ways) {
    const auto why_no_error = [](const std::string& written) {
        return refusal_of([&] { static_cast<void>(shape(written)); });
    };
    EXPECT_NE(why_no_error("p.grad p.q").find("parentheses that show what grad applies to"), std::string::npos);
    // An operator that another one applies to within a chain is of that chain: not p.grad(div(Q.p)).
    EXPECT_NE(why_no_error("p.grad div Q.p").find("parentheses that show what grad applies to"), std::string::npos);
    EXPECT_NE(why_no_error("lap phi^2").find("(lap phi)^..."), std::string::npos);
    EXPECT_NE(why_no_error("|p").find("ends the norm"), std::string::npos);
    EXPECT_NE(why_no_error("grad").find("the operand of grad"), std::string::npos);
    EXPECT_NE(why_no_error("outer(p)").find("a second argument of outer"), std::string::npos);
}

}  // namespace
}  // namespace drover::formula_tests
