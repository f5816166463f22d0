"""One file a family of statistics: what they are (``INFOS``) and their values (``finish``)."""
