/* A filter's model in a library that is already loaded, such as one that evaluates an FMU: `block + PARAMETERS` has the
   addresses of its two functions and of their argument. The inputs are constant over a step, so they are passed only with
   its first evaluation. */
#include <string.h>

typedef int Evaluate(void *argument, const double *x, const double *u, double *value, double *entries);
typedef struct {
    Evaluate *f, *h;
    void *argument;
} Model;

static Model model_of(const double *block)
{
    Model model;
    memcpy(&model, block + PARAMETERS, sizeof model);
    return model;
}

static int slope(const double *block, const double *x, double *f)
{
    const Model model = model_of(block);
    return model.f(model.argument, x, 0, f, 0);
}

static int slope_and_jacobian(const double *block, const double *x, double *f, double *A)
{
    const Model model = model_of(block);
    return model.f(model.argument, x, block + INPUT, f, A);
}

static int expected(const double *block, const double *x, double *h, double *H)
{
    const Model model = model_of(block);
    return model.h(model.argument, x, 0, h, H);
}
