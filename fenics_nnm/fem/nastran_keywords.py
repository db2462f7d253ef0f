"""Which cards of Nastran bulk data have no effect here, and which cannot be followed.

What is not on the list of harmless ones is refused by its name: it may change the structure.
"""

from __future__ import annotations

import re

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.nastran_cards import BulkCard

#: Cards of what the study states itself, or that have no effect on mass and stiffness.
_STATED = re.compile(
    r"MAT\w*|CREEP|PSOLID|PLSOLID|PSHELL|PLPLANE|PCOMP\w*|PBAR\w*|PBEAM\w*|PROD|PTUBE|NSMADD|"
    r"PLOAD\d?|FORCE\d?|MOMENT\d?|GRAV|RFORCE\d?|ACCEL\d?|TEMP\w*|LOAD|DLOAD|LSEQ|"
    r"TLOAD\d|RLOAD\d|DAREA|DELAY|DPHASE|DEFORM|SPC|SPC1|SPCADD|SPCD|SPCR|SUPORT1?|TIC|"
    r"ASET1?|QSET1?|BSET1?|CSET1?|OMIT1?|USET1?|SEQGP|EIG\w+|TABLE\w+|TABDMP\d|TABRND\w|FREQ\d?|"
    r"TSTEP\w*|TF|PARAM|MDLPRM|NLPARM|NLPCI|NLSTEP|SET\d?|PLOTEL\w*|BSURFS?|BCTABLE|BCTABL1|"
    r"BCTSET|BCTADD|BCTPARM|BCPARA|BCONP|BLSEG|BFRIC|BCBODY1?|BCBDPRP|BCONTACT|BCRPARA|BCSCAP|"
    r"BCPROPS?|BCGRID|BCONPRG|BCONPRP|DES\w+|DV\w+REL\d|DRESP\d|DCONSTR|DCONADD|DOPTPRM|DLINK|DEQATN|DTI"
)

#: What cards that change the structure do.
_REASONS = {
    r"RBE\d\w?|RTRPLT\d?|RJOINT|RSPLINE|RSSCON|MPC\w+": "it makes nodes move together",
    r"C(ELAS|BUSH)\w*|GENEL|CWELD|CFAST|CSEAM|CVISC|CDAMP\d": "it joins nodes or adds stiffness",
    r"CMASS\d|CONM\d|NSM\w*": "it adds mass that is not that of a point",
    r"C(BAR|BEAM|BEAM3|BEND|ROD|TUBE|SHEAR)|CONROD": "it is a bar or beam beside solids",
    r"CGAP": "contact must be [contact] of the study",
    r"DMIG\w*|DMI\w*|K2\w*|M2\w*": "it adds matrices",
    r"BGSET|BGADD|BGPARM": "it glues parts: merge the nodes of both sides",
    r"CYJOIN|CYSYM|CYAX": "it joins the two sides of a sector",
}


def is_stated(card: BulkCard) -> bool:
    """Whether a card is left out because the study states it, or it has no effect."""
    return _STATED.fullmatch(card.name) is not None


def refuse(card: BulkCard) -> None:
    """Refuse a card that is neither followed nor without effect.

    Raises:
        MeshError: always.
    """
    reasons = (why for names, why in _REASONS.items() if re.fullmatch(names, card.name))
    unknown = "it is not known, and may change the structure: must be left out of the file"
    raise MeshError(f"{card.place}: {card.name} cannot be followed: {next(reasons, unknown)}")
