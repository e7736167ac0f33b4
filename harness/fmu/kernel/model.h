/* The model of a filter by an FMU: `block + PARAMETERS` holds the addresses of model_exchange.c and of its argument. The
   inputs are set once a step, with the first of its points. */
#include <string.h>

typedef int Evaluate(void *fmu, const double *x, const double *u, double *value, double *entries);
typedef struct {
    Evaluate *derivative, *output;
    void *fmu;
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
    return model.derivative(model.fmu, x, 0, f, 0);
}

static int slope_and_jacobian(const double *block, const double *x, double *f, double *A)
{
    const Model model = model_of(block);
    return model.derivative(model.fmu, x, block + HELD, f, A);
}

static int expected(const double *block, const double *x, double *h, double *H)
{
    const Model model = model_of(block);
    return model.output(model.fmu, x, 0, h, H);
}
