"""Judgement of a run by the twin's truth alone, independent of controller and procedure."""
