/* Cholesky factors L L^T of CHOLMOD whose two triangular systems are solved one by one, and whose
   last rows can be read: what PETSc's interface of CHOLMOD lacks. Compiled by cholesky.py. */

#include <stdlib.h>
#include <string.h>

#if __has_include(<suitesparse/cholmod.h>)
#include <suitesparse/cholmod.h>
#else
#include <cholmod.h>
#endif

typedef struct {
    cholmod_common common;
    cholmod_factor *L;
    cholmod_dense *E; /* workspace, kept from one solve to the next */
} nnm_factors;

/* Whether the library is of the version whose records this was compiled for. */
static int nnm_fits(void)
{
    int version[3];
    cholmod_version(version);
    return version[0] == CHOLMOD_MAIN_VERSION && version[1] == CHOLMOD_SUB_VERSION;
}

static void nnm_free(nnm_factors *f)
{
    cholmod_free_factor(&f->L, &f->common);
    cholmod_free_dense(&f->E, &f->common);
    cholmod_finish(&f->common);
    free(f);
}

/* Factors of the symmetric matrix of n rows in compressed rows, of which the entries on and after
   the diagonal are read. NULL where it is not positive definite or memory is short. */
static nnm_factors *nnm_factorise(int n, int *starts, int *columns, double *values)
{
    nnm_factors *f = calloc(1, sizeof(*f));
    if (!f)
        return NULL;
    cholmod_common *common = &f->common;
    cholmod_start(common);
    common->print = 0;
    common->supernodal = CHOLMOD_SUPERNODAL;
    common->quick_return_if_not_posdef = 1;
    common->nmethods = 1;
    common->method[0].ordering = CHOLMOD_NATURAL;
    common->postorder = 1;

    cholmod_sparse A; /* rows after the diagonal are columns below it */
    memset(&A, 0, sizeof(A));
    A.nrow = A.ncol = (size_t)n;
    A.nzmax = (size_t)starts[n];
    A.p = starts;
    A.i = columns;
    A.x = values;
    A.stype = -1;
    A.itype = CHOLMOD_INT;
    A.xtype = CHOLMOD_REAL;
    A.dtype = CHOLMOD_DOUBLE;
    A.packed = 1;

    f->L = cholmod_analyze(&A, common);
    if (f->L)
        cholmod_factorize(&A, f->L, common);
    if (!f->L || common->status != CHOLMOD_OK || !f->L->is_super || f->L->minor < f->L->n) {
        nnm_free(f);
        return NULL;
    }
    return f;
}

/* Rows of the matrix in the order of the factors. */
static void nnm_order(nnm_factors *f, int *order)
{
    memcpy(order, f->L->Perm, f->L->n * sizeof(int));
}

/* Solve L y = b, or L^T x = y, in place, for columns of n entries one after the other. */
static int nnm_solve(nnm_factors *f, int transposed, int count, double *columns)
{
    size_t work = (size_t)count * f->L->maxesize;
    if (!f->E || f->E->nzmax < work) {
        cholmod_free_dense(&f->E, &f->common);
        f->E = cholmod_zeros(work > 0 ? work : 1, 1, CHOLMOD_REAL, &f->common);
        if (!f->E)
            return 0;
    }
    cholmod_dense B;
    memset(&B, 0, sizeof(B));
    B.nrow = B.d = f->L->n;
    B.ncol = (size_t)count;
    B.nzmax = B.nrow * B.ncol;
    B.x = columns;
    B.xtype = CHOLMOD_REAL;
    B.dtype = CHOLMOD_DOUBLE;
    if (transposed)
        return cholmod_super_ltsolve(f->L, &B, f->E, &f->common);
    return cholmod_super_lsolve(f->L, &B, f->E, &f->common);
}

/* The last count rows and columns of L, one column after the other; `lower` is zero before. */
static void nnm_last(nnm_factors *f, int count, double *lower)
{
    cholmod_factor *L = f->L;
    int *super = L->super, *pi = L->pi, *px = L->px, *s = L->s;
    int first = (int)L->n - count;
    double *x = L->x;
    for (int k = (int)L->nsuper - 1; k >= 0 && super[k + 1] > first; k--) {
        int rows = pi[k + 1] - pi[k];
        for (int j = super[k] > first ? super[k] : first; j < super[k + 1]; j++) {
            double *column = x + px[k] + (size_t)(j - super[k]) * (size_t)rows;
            for (int r = j - super[k]; r < rows; r++)
                lower[(size_t)(j - first) * (size_t)count + (size_t)(s[pi[k] + r] - first)] =
                    column[r];
        }
    }
}
